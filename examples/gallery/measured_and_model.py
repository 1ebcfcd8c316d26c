"""Records beside the model, before and after: run `mechid demo` first (synthetic bench)."""

from dataclasses import replace

import matplotlib.pyplot as plt

import mechid

fit = mechid.load_fit("mechid-demo")
models = {"model, catalogue": (fit.campaign.mechanism, "C1--"), "model, estimated": (fit.mechanism, "C0-")}
figure, axes = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
for ax, name in zip(axes, ["full_46", "micro_46"], strict=True):
    data = next(record.data for record in fit.campaign.records if record.name == name)
    ax.plot(data.time_s, data.channels[0].data - fit.records[name].offset, "0.6", lw=3.5, label="bench (synthetic)")
    for label, (mechanism, style) in models.items():
        model = mechid.simulate(replace(fit.campaign, mechanism=mechanism), name)
        ax.plot(model.time, model.torque, style, lw=1.2, label=label)
    ax.set(xlim=(0.0, 0.2), xlabel="time in s", ylabel="torque in N m", title=f"{name}: 46 steps/s")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
figure.savefig("measured_and_model.png", dpi=120)
