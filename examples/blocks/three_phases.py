"""Three phases in star, six states a turn of the electrical angle: the currents of the terminals (simulated)."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import mechid

MOTOR = {
    "drive": "voltage",
    "poles": 20,
    "phases": 3,
    "peak_voltage": 12.0,
    "coil_resistance": 9.0,
    "coil_inductance": 0.03,
    "torque_constant": 0.3,
    "rotor_inertia": 2e-5,
}
FRICTION = {"static": 0.01, "coulomb": 0.008, "viscous": 2e-3}
CURRENTS = [f"current_phase_{phase}" for phase in "abc"]
ASKED = (*CURRENTS, "rotor_angle", "torque")

table = {"assembly": "current_driven_stepper", "stepper": MOTOR, "friction": FRICTION}
mechanism = mechid.make_mechanism(table)
figure, axes = plt.subplots(3, 1, figsize=(11, 8), sharex=True, layout="constrained")
for start_angle_deg, words, style in ((0.0, "three phases on", "-"), (30.0, "two phases on", "--")):
    command = mechid.make_command("full", rate=20.0, start_angle_deg=start_angle_deg, waveform="square")
    bench = mechid.make_campaign(mechanism, [mechid.make_record("steps", command=command)])
    bench = replace(bench, mechanism=replace(mechanism, plant=mechanism.plant.with_outputs(ASKED)))
    run = mechid.simulate(bench, "steps", sample_rate_hz=20e3, duration_s=0.4)
    for phase, color in zip("abc", ("C0", "C1", "C2"), strict=True):
        label = f"phase {phase}" if style == "-" else None
        axes[0].plot(run.time, run.values[f"current_phase_{phase}"], style, color=color, label=label)
    axes[1].plot(run.time, np.degrees(run.values["rotor_angle"]), style, color="k", label=words)
    axes[2].plot(run.time, run.values["torque"], style, color="k")
for axis, label in zip(axes, ("current, A", "rotor, deg", "torque on the base, N m"), strict=True):
    axis.set_ylabel(label)
axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
axes[1].legend()
axes[2].set_xlabel("time, s")
figure.savefig("three_phases.png", dpi=120)
