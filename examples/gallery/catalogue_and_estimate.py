"""How far the catalogue was off, parameter by parameter. Run `mechid demo` first."""

import json
from pathlib import Path

import matplotlib.pyplot as plt

parameters = json.loads(Path("mechid-demo/estimate.json").read_text(encoding="utf-8"))["parameters"]
found = {n: p for n, p in parameters.items() if p["std_error"] and p["start"] and "phase" not in n}
figure, ax = plt.subplots(figsize=(11, 3.9), layout="constrained")
for row, p in enumerate(found.values()):
    ratio = p["value"] / p["start"]
    ax.plot([1, ratio], [row, row], "0.7", lw=3)
    ax.errorbar(ratio, row, xerr=1.96 * p["std_error"] / p["start"], fmt="C0o", capsize=4)
ax.axvline(1.0, color="C1", label="catalogue")
ax.set(xscale="log", xlabel="estimate / catalogue, with the 95 % interval", yticks=range(len(found)))
ax.set_yticklabels([f"{n} [{p['unit']}]" for n, p in found.items()])
ax.legend()
figure.savefig("catalogue_and_estimate.png", dpi=120)
