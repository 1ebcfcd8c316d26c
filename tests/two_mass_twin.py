"""A two-mass drive by a simulator that shares no line with mechid: SciPy's, for records measured on both sides.

Motor and load on a spring and a damper, seen from the output as a gear maker's data sheet has them; dry and viscous
friction at the motor. Between switches of the friction the masses are linear: `scipy.linalg.expm` steps them.
"""

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.linalg import expm

RATE_HZ = 1000.0
SUBSTEPS = 100
RATIO = 50.0
TRUTH = {
    "motor.inertia": 2e-4,
    "friction.coulomb": 0.05,
    "friction.viscous": 1.5e-3,
    "gear.stiffness": 4e3,
    "gear.damping": 1.5,
    "load.inertia": 1.2,
}
NOISE = {"rotor_angle": 2e-3, "output_angle": 1e-4}
MECHANISM = """assembly = "two_mass_drive"

[motor]
inertia = {{ value = 2.6e-4, min = 5e-5, max = 1e-3 }}

[friction]
coulomb = {{ value = 0.03, min = 0.0, max = 0.5 }}
viscous = {{ value = 1e-3, min = 0.0, max = 0.02 }}

[gear]
ratio = 50.0
stiffness = {{ value = 5e3, min = 5e2, max = 4e4 }}
damping = {{ value = {damping}, min = {least}, max = 50.0 }}

[load]
inertia = {{ value = 1.0, min = 0.1, max = 10.0 }}
"""
RECORD = """[[record]]
name = "{name}"
file = "{name}.csv"
use = "{use}"
offset = false
drift = false
time = {{ column = "time", unit = "s" }}
channels = [
  {{ quantity = "torque", column = "torque", unit = "N*m", role = "input" }},
  {{ quantity = "rotor_angle", column = "rotor_angle", unit = "rad" }},
  {{ quantity = "output_angle", column = "output_angle", unit = "rad" }},
]
{own}
"""


def torque_at(seconds: float, seed: int) -> np.ndarray:
    """Return a torque of several lines about none, that starts at 0, a value a sample; N m."""
    t = np.arange(round(seconds * RATE_HZ) + 1) / RATE_HZ
    rng = np.random.default_rng(seed)
    lines_hz = np.array([0.7, 1.9, 4.3, 7.7, 11.3])
    phases = rng.uniform(0.0, 2.0 * np.pi, lines_hz.size)
    sines = np.sin(2.0 * np.pi * lines_hz[:, None] * t + phases[:, None])
    return 0.25 * np.tanh(4.0 * t) * sines.sum(axis=0)


def simulate_two_masses(torque: np.ndarray, truth: Mapping[str, float] = TRUTH) -> np.ndarray:
    """Return rotor and output angle of both masses at each sample, (2, n) rad, from rest.

    While the motor moves one way, or is held, the masses are linear: each of the `SUBSTEPS` of a sample is exact.
    Friction reverses or takes hold at the end of the substep in which the motor's speed passes 0.
    """
    moves, held = (_discrete(truth, is_held=way) for way in (False, True))
    dry, state, out = truth["friction.coulomb"], np.zeros(4), [np.zeros(4)]
    way = 0.0
    for begin, end in pairwise(torque):
        for k in range(SUBSTEPS):
            pull = begin + (end - begin) * (k + 0.5) / SUBSTEPS
            if way == 0.0 and abs(left := pull - _gear(state, truth) / RATIO) > dry:
                way = math.copysign(1.0, left)
            A, B = moves if way else held
            state = A @ state + B * (pull - way * dry)
            if way and state[1] * way < 0.0:
                state[1], way = 0.0, 0.0
        out.append(state.copy())
    return np.array(out).T[[0, 2]]


def _gear(x: np.ndarray, truth: Mapping[str, float]) -> float:
    """Return the torque of the gear on the load."""
    wound, winding = x[0] / RATIO - x[2], x[1] / RATIO - x[3]
    return float(truth["gear.stiffness"] * wound + truth["gear.damping"] * winding)


def _discrete(truth: Mapping[str, float], *, is_held: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices of a substep under a constant torque: SciPy's matrix exponential of the linear masses."""
    K, D, J, M = (truth[key] for key in ("gear.stiffness", "gear.damping", "motor.inertia", "load.inertia"))
    by_gear = np.array([K / RATIO, D / RATIO, -K, -D])
    whole = np.zeros((5, 5))
    whole[2, 3] = 1.0
    whole[3, :4] = by_gear / M
    if not is_held:
        whole[0, 1] = 1.0
        whole[1, :4] = -by_gear / (RATIO * J)
        whole[1, 1] -= truth["friction.viscous"] / J
        whole[1, 4] = 1.0 / J
    found = expm(whole / (RATE_HZ * SUBSTEPS))
    return found[:4, :4], found[:4, 4]


def write_two_masses(
    folder: Path,
    records: Mapping[str, tuple[float, int, str, str]],
    *,
    truth: Mapping[str, float] = TRUTH,
    torque_late_samples: float = 0.0,
    least: float = 0.0,
    noise: Mapping[str, float] = NOISE,
) -> Path:
    """Write a campaign of records (seconds, seed, use, further lines).

    In those that are held out the torque is recorded late by so many samples.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = MECHANISM.format(damping=max(3.0, 1.5 * least), least=least)
    (folder / "mechanism.toml").write_text(text, encoding="utf-8")
    entries = ['mechanism = "mechanism.toml"\n']
    for name, (seconds, seed, use, own) in records.items():
        torque, rng = torque_at(seconds, seed), np.random.default_rng(1000 + seed)
        angles = dict(zip(NOISE, simulate_two_masses(torque, truth), strict=True))
        time = np.arange(torque.size) / RATE_HZ
        late_s = torque_late_samples / RATE_HZ if use == "validate" else 0.0
        torque = np.interp(time - late_s, time, torque)
        columns = [time, torque, *(angle + noise[q] * rng.standard_normal(time.size) for q, angle in angles.items())]
        np.savetxt(
            folder / f"{name}.csv",
            np.stack(columns, axis=1),
            delimiter=",",
            header="time,torque,rotor_angle,output_angle",
            comments="",
            fmt="%.9g",
        )
        entries.append(RECORD.format(name=name, use=use, own=own))
    (folder / "campaign.toml").write_text("\n".join(entries), encoding="utf-8")
    return folder
