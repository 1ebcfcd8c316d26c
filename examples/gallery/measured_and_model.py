"""A record beside the model, before and after: run `mechid demo` first (synthetic bench)."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mechid

figure, axes = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
for ax, name in zip(axes, ["full_46", "micro_46"], strict=True):
    time, torque = np.loadtxt(f"mechid-demo/{name}.csv", delimiter=",", skiprows=1).T
    ax.plot(time, torque - torque.mean(), color="0.6", lw=3.5, label="bench (synthetic)")
    for file, style in [("mechanism", "C1--"), ("mechanism_estimated", "C0-")]:
        campaign = mechid.load_campaign("mechid-demo", mechanism_file=Path(f"mechid-demo/{file}.toml"))
        model = mechid.simulate(campaign, name)
        ax.plot(model.time, model.torque, style, lw=1.2, label=file)
    ax.set(xlim=(0.0, 0.2), xlabel="time in s", ylabel="torque in N m", title=f"{name}: 46 steps/s")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
figure.savefig("measured_and_model.png", dpi=120)
