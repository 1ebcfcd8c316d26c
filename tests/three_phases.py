"""A motor with three phases in star: its file, and its equations typed by hand for SciPy, phase by phase.

The star point floats, so that its potential keeps the sum of the three currents at zero; nothing here is on axes.
"""

from collections.abc import Mapping

import numpy as np
from scipy.integrate import solve_ivp

from layouts import changed, mechanism_of
from mechid.command import Command, RateProfile

FILE: Mapping = {
    "assembly": "current_driven_stepper",
    "stepper": {
        "drive": "voltage",
        "phases": 3,
        "poles": 20,
        "peak_voltage": 12.0,
        "coil_resistance": 8.0,
        "coil_inductance": 0.012,
        "torque_constant": 0.11,
        "back_emf_constant": 0.1,
        "rotor_inertia": 4e-5,
        "detent": [{"period_deg": 6.0, "amplitude": 0.01, "phase_deg": 25.0}],
        "torque_harmonic": [
            {"order": 5, "amplitude": 0.06, "phase_deg": 20.0},
            {"order": 7, "amplitude": 0.04, "phase_deg": -50.0},
            {"order": 2, "amplitude": 0.03, "phase_deg": 70.0},
            {"order": 4, "amplitude": 0.02, "phase_deg": 10.0},
        ],
    },
    "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 2e-3},
}
"""Without dry friction, so that nothing switches but the driver."""
QUANTITIES = ("torque", "current_phase_a", "current_phase_b", "current_phase_c", "rotor_angle", "rotor_rate")
SHIFTS = np.radians([0.0, 120.0, 240.0])


def star(changes: Mapping | None = None, quantities=QUANTITIES):
    """Return the mechanism with all of its quantities as outputs."""
    from dataclasses import replace

    made = mechanism_of(changed(FILE, changes or {}))
    return replace(made, plant=made.plant.with_outputs(quantities))


def stepped(rate, microsteps=1, **entries):
    """Return a command of one rate."""
    stepping = {1: "full", 2: "half"}.get(microsteps, "micro")
    return Command(stepping=stepping, microsteps=microsteps, rate=RateProfile.constant(rate), phases=3, **entries)


def terminals(command, step):
    """Return the voltage of each terminal, over U, that a driver of three half bridges sets at a step."""
    theta = np.radians(command.start_angle_deg) + step * np.radians(60.0) / command.microsteps
    wave = -np.cos(theta + SHIFTS)
    wave[np.abs(wave) < 1e-12] = 0.0
    return np.sign(wave) if command.waveform == "square" else wave


def coupling(angle):
    """Return the torque of each phase over k_m i, and the back-EMF over k_v omega."""
    x = 10.0 * angle + SHIFTS
    shape = np.sin(x)
    for h in FILE["stepper"]["torque_harmonic"]:
        shape = shape + h["amplitude"] * np.sin(h["order"] * x + np.radians(h["phase_deg"]))
    return shape


def rates(state, voltages):
    """Return d/dt of three currents, angle, rate, and of the energies supplied, heating and mechanical."""
    own, i, angle, omega = FILE["stepper"], state[:3], state[3], state[4]
    shape = coupling(angle)
    u = own["peak_voltage"] * voltages - own["coil_resistance"] * i - own["back_emf_constant"] * omega * shape
    detent = 0.01 * np.sin(60.0 * angle + np.radians(25.0))
    net = own["torque_constant"] * np.sum(i * shape) - detent - 2e-3 * omega
    return np.array([*(u - np.mean(u)) / own["coil_inductance"], omega, net / own["rotor_inertia"]])


def integrate(command, times):
    """Return currents, angle and rate at `times`, (n, 5), by SciPy from one step of the driver to the next."""
    own, step_s = FILE["stepper"], 1.0 / (command.rate.rates[0] * command.microsteps)
    u = terminals(command, 0)
    i = own["peak_voltage"] * (u - np.mean(u)) / own["coil_resistance"]
    state, out = np.array([*i, np.radians(command.start_angle_deg) / 10.0, 0.0]), [np.zeros(5)]
    out[0] = state
    for k in range(round(times[-1] / step_s) + 1):
        ends = k * step_s, min((k + 1) * step_s, times[-1])
        inside = times[(times > ends[0] + 1e-12) & (times <= ends[1] + 1e-12)]
        if not inside.size:
            continue
        at = np.unique(np.append(inside, ends[1]))
        done = solve_ivp(
            lambda _, y, v: rates(y, v),
            ends,
            state,
            "DOP853",
            np.minimum(at, ends[1]),
            args=(terminals(command, k),),
            rtol=1e-13,
            atol=1e-15,
        )
        out.extend(done.y.T[: inside.size])
        state = done.y[:, -1]
    return np.array(out)
