"""A drive in pulses beside one that holds: current and voltage of a coil, and the rotor's swing (simulated)."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import mechid

MOTOR = {
    "poles": 100,
    "drive": "voltage",
    "peak_voltage": 12.0,
    "coil_resistance": 9.0,
    "coil_inductance": 0.03,
    "torque_constant": 0.3,
    "rotor_inertia": 2e-5,
    "detent": [{"period_deg": 1.8, "amplitude": 0.02, "phase_deg": 180.0}],
}
OPEN = {"on_s": 0.05, "between": "open", "clamp_V": 8.0, "diode_drop_V": 0.7}
FRICTION = {"static": 0.006, "coulomb": 0.005, "viscous": 5e-4}
ASKED = {
    "current_phase_a": "current of phase A, A",
    "voltage_phase_a": "voltage of phase A, V",
    "rotor_angle": "rotor, deg",
}

figure, axes = plt.subplots(3, 1, figsize=(11, 8), sharex=True, layout="constrained")
for name, pulses in (("held", {}), ("in pulses of 50 ms, then open", {"pulses": OPEN})):
    table = {"assembly": "current_driven_stepper", "stepper": {**MOTOR, **pulses}, "friction": FRICTION}
    command = mechid.make_command("full", rate=10.0, start_angle_deg=45.0)
    mechanism = mechid.make_mechanism(table)
    bench = mechid.make_campaign(mechanism, [mechid.make_record("steps", command=command)])
    bench = replace(bench, mechanism=replace(mechanism, plant=mechanism.plant.with_outputs(tuple(ASKED))))
    run = mechid.simulate(bench, "steps", sample_rate_hz=20e3, duration_s=0.35)
    for axis, (quantity, label) in zip(axes, ASKED.items(), strict=True):
        values = np.asarray(run.values[quantity])
        axis.plot(run.time, np.degrees(values) if quantity == "rotor_angle" else values, label=name)
        axis.set_ylabel(label)
axes[0].legend()
axes[-1].set_xlabel("time, s")
figure.savefig("pulsed_drive.png", dpi=120)
