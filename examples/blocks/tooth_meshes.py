"""Lines of two tooth meshes in the torque of a geared stepper, named by their orders (simulated)."""

import matplotlib.pyplot as plt
import numpy as np

import mechid

RATE, SECONDS = 40.0, 40.0
MESHES = [{"teeth": [71, 69]}, {"teeth": [73, 80], "ratio_behind": 50.0 * 71.0 * 73.0 / (69.0 * 80.0)}]
ERRORS = [{"order": f"mesh {k}", "amplitude": 2e-5, "phase_deg": 20.0} for k in (1, 2)]
MOTOR = {
    "poles": 100,
    "peak_voltage": 12.0,
    "coil_resistance": 9.0,
    "coil_inductance": 0.03,
    "torque_constant": 0.3,
    "rotor_inertia": 2e-5,
}
GEAR = {"ratio": 50, "stiffness": 1000.0, "damping": 0.5, "mesh": MESHES, "kinematic_error": ERRORS}
FRICTION = {"static": 0.01, "coulomb": 0.008, "viscous": 2e-3}

mechanism = mechid.make_mechanism({"stepper": MOTOR, "friction": FRICTION, "gear": GEAR, "load": {"inertia": 0.0105}})
command = mechid.make_command("micro", rate=RATE, microsteps=16)
bench = mechid.make_campaign(mechanism, [mechid.make_record("micro", command=command)])
run = mechid.simulate(bench, "micro", sample_rate_hz=2000.0, duration_s=SECONDS)
torque = run.torque[run.time > 2.0]
amplitude = 2.0 * np.abs(np.fft.rfft((torque - torque.mean()) * np.hanning(torque.size))) / (0.5 * torque.size)
order = np.fft.rfftfreq(torque.size, 1.0 / 2000.0) / RATE
figure, axis = plt.subplots(figsize=(11, 4.5), layout="constrained")
axis.semilogy(order, amplitude, lw=0.8)
for line in mechanism.named_lines:
    if line.name in ("mesh 1", "mesh 2"):
        axis.axvline(line.order, color="C1", ls=":", lw=1.0)
        side = "right" if line.name == "mesh 1" else "left"
        axis.annotate(line.name, (line.order, 3e-3), rotation=90, va="bottom", ha=side, color="C1")
axis.set(xlim=(0.0, 4.2), ylim=(1e-7, 1e-1), xlabel="order of the full-step rate", ylabel="amplitude, N m")
figure.savefig("tooth_meshes.png", dpi=120)
