"""A sweep of the step rate, measured and modelled: where resonances are met. Run `mechid demo` first."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mechid

campaign = mechid.load_campaign("mechid-demo", mechanism_file=Path("mechid-demo/mechanism_estimated.toml"))
model = mechid.simulate(campaign, "sweep")
time, torque = np.loadtxt("mechid-demo/sweep.csv", delimiter=",", skiprows=1).T
figure, ax = plt.subplots(figsize=(11, 3.6), layout="constrained")
for values, colour, label in [(torque - torque.mean(), "0.6", "bench (synthetic)"), (model.torque, "C0", "model")]:
    largest = values[: len(values) // 2000 * 2000].reshape(-1, 2000)
    at = time[: largest.size : 2000]
    ax.fill_between(2 * at, largest.min(1), largest.max(1), color=colour, alpha=0.7, label=label)
ax.set(xlabel="step rate in full steps/s", ylabel="torque in N m")
ax.legend(loc="upper left")
figure.savefig("sweep.png", dpi=120)
