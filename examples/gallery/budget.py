"""The line of sight over the step rate, and each requirement. Run `mechid demo` first (all of it synthetic)."""

import matplotlib.pyplot as plt

import mechid

budget = mechid.budget("mechid-demo/budget.toml")
figure, axes = plt.subplots(2, 1, figsize=(11, 7), layout="constrained")
budget.plot(ax=axes[0])
budget.plot("scan", ax=axes[1])
figure.savefig("budget.png", dpi=120)
