"""Which parameters the records tell apart, and which go together. Run `mechid demo` first."""

import json
from pathlib import Path

import matplotlib.pyplot as plt

correlation = json.loads(Path("mechid-demo/estimate.json").read_text(encoding="utf-8"))["correlation"]
names = correlation["names"]
figure, ax = plt.subplots(figsize=(8, 6.4), layout="constrained")
image = ax.imshow(correlation["matrix"], cmap="RdBu", vmin=-1, vmax=1)
ax.set_xticks(range(len(names)), names, rotation=90)
ax.set_yticks(range(len(names)), names)
figure.colorbar(image, label="correlation of the estimates")
figure.savefig("correlation.png", dpi=120)
