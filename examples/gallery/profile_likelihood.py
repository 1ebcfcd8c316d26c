"""The likelihood's own shape beside the parabola of its standard error. Run `mechid demo` first."""

import matplotlib.pyplot as plt
import numpy as np

import mechid

fit = mechid.load_fit("mechid-demo")
name = "friction.coulomb"
profile, estimate = mechid.profile(fit, name)[name], fit.parameters[name]
value = np.array([point.value for point in profile.points])
order = np.argsort(value)
figure, ax = plt.subplots(figsize=(8, 3.6), layout="constrained")
ax.plot(value[order], np.array([point.rise for point in profile.points])[order], "C0o-", label="likelihood")
ax.plot(value[order], ((value[order] - estimate.value) / estimate.std_error) ** 2, "C1--", label="standard error")
ax.axhline(profile.level, color="0.6", label="95 %")
ax.set(xlabel=f"{name} in {estimate.unit}", ylabel="rise of the cost, 2 times its logarithm")
ax.legend()
figure.savefig("profile_likelihood.png", dpi=120)
