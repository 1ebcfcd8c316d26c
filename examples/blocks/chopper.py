"""A chopped current drive: a phase's current under slow, mixed and fast decay (simulated)."""

from dataclasses import replace

import matplotlib.pyplot as plt

import mechid

MOTOR = {
    "poles": 100,
    "drive": "current",
    "peak_current": 0.5,
    "torque_constant": 0.3,
    "rotor_inertia": 2e-5,
    "current_limit": {"voltage": 28.0, "resistance": 9.9, "inductance": 0.02},
}
FRICTION = {"static": 0.006, "coulomb": 0.005, "viscous": 5e-4}
CLOCK = {"frequency_hz": 12e3}
CHOPPERS = {
    "slow": CLOCK,
    "mixed": {**CLOCK, "decay": "mixed", "fast_s": 2e-5},
    "band of 40 mA, fast": {"hysteresis_A": 0.04, "decay": "fast"},
}

command = mechid.make_command("micro", rate=150.0, microsteps=4)
figure, axes = plt.subplots(3, 1, figsize=(11, 8), sharex=True, sharey=True, layout="constrained")
for axis, (name, chop) in zip(axes, CHOPPERS.items(), strict=True):
    table = {"assembly": "current_driven_stepper", "stepper": {**MOTOR, "chop": chop}, "friction": FRICTION}
    mechanism = mechid.make_mechanism(table)
    bench = mechid.make_campaign(mechanism, [mechid.make_record("steps", command=command)])
    bench = replace(bench, mechanism=replace(mechanism, plant=mechanism.plant.with_outputs(("current_phase_a",))))
    run = mechid.simulate(bench, "steps", sample_rate_hz=1e6, duration_s=0.04, substeps=1)
    axis.plot(run.time, run.values["current_phase_a"], lw=0.7, label=name)
    axis.set_ylabel("current of phase A, A")
    axis.legend(loc="upper right")
axes[-1].set_xlabel("time, s")
figure.savefig("chopper.png", dpi=120)
