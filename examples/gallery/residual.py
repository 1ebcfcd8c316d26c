"""What is left of a record when the model is taken off: noise, if nothing is missing. Run `mechid demo` first."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mechid

campaign = mechid.load_campaign("mechid-demo", mechanism_file=Path("mechid-demo/mechanism_estimated.toml"))
time, torque = np.loadtxt("mechid-demo/micro_46.csv", delimiter=",", skiprows=1).T
left = torque - mechid.simulate(campaign, "micro_46").torque
left -= np.polyval(np.polyfit(time, left, 1), time)  # offset and drift of the amplifier
figure, (ax, bars) = plt.subplots(1, 2, figsize=(11, 3.2), layout="constrained", width_ratios=(3, 1), sharey=True)
ax.plot(time, 1e3 * left, "C0", lw=0.5)
ax.set(xlabel="time in s", ylabel="residual in mN m", xlim=(0, 1))
bars.hist(1e3 * left, bins=60, orientation="horizontal", density=True, color="C0")
sigma, at = left.std(), np.linspace(-8e-3, 8e-3, 200)
bars.plot(np.exp(-0.5 * (at / sigma) ** 2) / (1e3 * sigma * np.sqrt(2 * np.pi)), 1e3 * at, "C1")
figure.savefig("residual.png", dpi=120)
