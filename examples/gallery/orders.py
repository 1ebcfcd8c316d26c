"""Orders of the step rate over a sweep: the waterfall of the model's torque. Run `mechid demo` first."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import ShortTimeFFT

import mechid

campaign = mechid.load_campaign("mechid-demo", mechanism_file=Path("mechid-demo/mechanism_estimated.toml"))
model = mechid.simulate(campaign, "sweep")
short = ShortTimeFFT.from_window("hann", 10_000.0, 10_000, 9_000, scale_to="magnitude")
lines = np.abs(short.stft(np.asarray(model.torque)))
rate = 2.0 * short.t(model.torque.size)
figure, ax = plt.subplots(figsize=(11, 4.2), layout="constrained")
image = ax.pcolormesh(rate, short.f[:260], 20 * np.log10(lines[:260] + 1e-9), vmin=-100, vmax=-20, rasterized=True)
ax.set(xlim=(0, 120), xlabel="step rate in full steps/s", ylabel="frequency in Hz")
figure.colorbar(image, label="amplitude, dB of 1 N m")
figure.savefig("orders.png", dpi=100)
