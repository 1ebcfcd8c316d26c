"""Lines of a record at one step rate, measured and modelled. Run `mechid demo` first."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mechid

campaign = mechid.load_campaign("mechid-demo", mechanism_file=Path("mechid-demo/mechanism_estimated.toml"))
figure, ax = plt.subplots(figsize=(11, 3.6), layout="constrained")
model = mechid.simulate(campaign, "full_46")
time, torque = np.loadtxt("mechid-demo/full_46.csv", delimiter=",", skiprows=1).T
for values, style, label in [(torque, "0.6", "bench (synthetic)"), (model.torque, "C0", "model")]:
    part = values[time >= 0.5] - values[time >= 0.5].mean()
    lines = np.abs(np.fft.rfft(part * np.hanning(part.size))) * 4 / part.size
    ax.semilogy(np.fft.rfftfreq(part.size, time[1] - time[0]), lines, style, label=label)
ax.set(xlim=(0, 1200), ylim=(1e-5, 2), xlabel="frequency in Hz", ylabel="amplitude in N m")
ax.legend()
figure.savefig("spectrum.png", dpi=120)
