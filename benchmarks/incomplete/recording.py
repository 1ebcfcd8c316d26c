"""The records of a bench: test runs, what the mechanism does in them, and what the instruments make of it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incomplete.effects import Size
from incomplete.plant import Values, run
from incomplete.stepping import edges
from mechid.plant.mechanism import Mechanism
from recovery.campaigns import DRIFT_NM, NOISE_NM, OFFSET_NM, RATE_HZ

Simulate = Callable[[Values, np.ndarray, np.ndarray, float, float, int, float], np.ndarray]
"""From what `plant.run` takes to the recorded torque, (samples,) N m."""


@dataclass(frozen=True)
class Run:
    """One test run: its command as a campaign file writes it, and how long it takes."""

    command: Mapping[str, Any]
    seconds: float


@dataclass(frozen=True)
class TrueRecord:
    """Time in s and torque in N m, both (samples,), and what was drawn for this record alone.

    `own` has supply and gain as shares of the nominal ones, offset and drift in N m, the delay of the command in s.
    """

    time_s: np.ndarray
    torque_Nm: np.ndarray
    own: Mapping[str, float]


def resonance_hz(mechanism: Mechanism) -> float:
    """Return the resonance of the load on the gear's spring, rotor held."""
    return math.sqrt(mechanism.value("gear.stiffness") / mechanism.value("load.inertia")) / (2.0 * math.pi)


def runs_of(mechanism: Mechanism) -> dict[str, Run]:
    """Return the test runs: full steps and microsteps about the resonance, full steps at 5 a second, a sweep of 8 s."""
    rate = round(0.98 * resonance_hz(mechanism), 1)
    micro: dict[str, Any] = {"stepping": "micro", "microsteps": 16}
    return {
        "full_res": Run(full_steps(rate), 1.0),
        "full_half": Run(full_steps(0.5 * rate), 1.0),
        "full_slow": Run(full_steps(5.0), 1.0),
        "half_res": Run({**full_steps(0.7 * rate), "stepping": "half"}, 1.0),
        "micro_res": Run({**micro, "rate": rate}, 1.0),
        "sweep": Run({**micro, "rate_profile": [[0.0, 0.0], [8.0, 2.4 * rate]]}, 8.0),
    }


def full_steps(rate: float) -> dict[str, Any]:
    """Return a command of full steps at a rate, from between two microsteps of equal currents."""
    return {"stepping": "full", "rate": rate, "start_angle_deg": 45.0}


def recorded(
    mechanism: Mechanism,
    size: Size,
    one: Run,
    rng: np.random.Generator | None,
    sample_rate_hz: float = RATE_HZ,
    simulate: Simulate = run,
) -> TrueRecord:
    """Return what the recorder writes of a run.

    `clock_ppm` of the size is how much too fast the recorder samples, `driver_ppm` how much too fast the driver steps.
    Offset, drift, noise, phase of the hum and what a record has of its own are drawn by `rng`; where it is None there
    are none of the first three, the phase is 0, and supply, gain and trigger are as nominal.
    """
    own = _own_values(size, rng)
    torque = noiseless(mechanism, size, one, own, sample_rate_hz, simulate)
    if rng:
        torque += NOISE_NM * rng.standard_normal(torque.size)
    if "resolution" in size:
        torque = size["resolution"] * np.round(torque / size["resolution"])
    return TrueRecord(np.arange(torque.size) / sample_rate_hz, torque, own)


def noiseless(
    mechanism: Mechanism,
    size: Size,
    one: Run,
    own: Mapping[str, float],
    sample_rate_hz: float = RATE_HZ,
    simulate: Simulate = run,
) -> np.ndarray:
    """Return the torque of a run with what the record has of its own, before noise and rounding, N m."""
    stretch = 1.0 + 1e-6 * size.get("clock_ppm", 0.0)
    values = values_of(mechanism, size, supply=own["supply"])
    samples = round(one.seconds * sample_rate_hz) + 1
    times, voltages = edges(one.command, 1.01 * one.seconds)
    times = times / (1.0 + 1e-6 * size.get("driver_ppm", 0.0))
    angle = math.radians(one.command.get("start_angle_deg", 0.0))
    interval = 1.0 / (sample_rate_hz * stretch)
    torque = simulate(values, times, voltages, angle, interval, samples, own["delay_s"]) * own["gain"]
    torque += own["offset_Nm"] + own["drift_Nm"] * np.linspace(0.0, 1.0, samples)
    if "mains_hz" in size:
        torque += _hum(size, np.arange(samples) / sample_rate_hz, own["hum_turns"])
    return torque


def _own_values(size: Size, rng: np.random.Generator | None) -> dict[str, float]:
    """Draw what a record has of its own; gain and trigger come last, so that sizes without them draw as ever."""
    draws = rng.standard_normal(4) if rng else np.zeros(4)
    apart = rng.uniform(size=2) if rng and size.keys() & {"gain", "trigger_s"} else np.array([0.5, 0.0])
    return {
        "supply": float(1.0 + size.get("supply", 0.0) * draws[0]),
        "offset_Nm": float(OFFSET_NM * draws[1]),
        "drift_Nm": float(DRIFT_NM * draws[2]),
        "hum_turns": float(draws[3]),
        "gain": float(1.0 + size.get("gain_common", 0.0) + size.get("gain", 0.0) * (2.0 * apart[0] - 1.0)),
        "delay_s": float(size.get("trigger_s", 0.0) * apart[1]),
    }


def _hum(size: Size, time: np.ndarray, phase: float) -> np.ndarray:
    turns = 2.0 * math.pi * (size["mains_hz"] * time + phase)
    return sum(size[f"mains_{k}"] * np.sin(k * turns) for k in (1, 2, 3))


def values_of(mechanism: Mechanism, size: Size, *, supply: float = 1.0) -> Values:
    """Return the simulator's values of a mechanism with an effect, its supply voltage a share of the nominal one."""
    value = mechanism.value
    detents = {}
    for k in (0, 1):
        detent = f"stepper.detent.{k}"
        detents[f"detent_order_{k + 1}"] = 360.0 / value(f"{detent}.period_deg")
        detents[f"detent_{k + 1}"] = value(f"{detent}.amplitude")
        detents[f"detent_phase_{k + 1}"] = math.radians(value(f"{detent}.phase_deg"))
    own = {key: float(number) for key, number in size.items() if key in Values._fields}
    return Values(
        U=supply * value("stepper.peak_voltage"),
        half_poles=0.5 * value("stepper.poles"),
        J_rot=value("stepper.rotor_inertia"),
        R=value("stepper.coil_resistance"),
        L=value("stepper.coil_inductance"),
        k_m=value("stepper.torque_constant"),
        static=value("friction.static"),
        coulomb=value("friction.coulomb"),
        viscous=value("friction.viscous"),
        G=float(value("gear.ratio")),
        K_s=value("gear.stiffness"),
        D=value("gear.damping"),
        J_m=value("load.inertia"),
        K_res=value("housing.gain"),
        w_0=value("housing.frequency"),
        zeta=value("housing.damping"),
        **detents,
        **own,
    )
