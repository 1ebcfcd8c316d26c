"""Test runs and held-out runs of a campaign, and the torque of the true mechanism in them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incomplete.plant import Values, run
from incomplete.stepping import edges

from ..mechid_benchmark.emission import RATE_HZ, WINDOW_S
from ..mechid_benchmark.tasks import HELD_OUT


@dataclass(frozen=True)
class Run:
    """One run: its command, with the keys of a mechid campaign file, and its length."""

    command: Mapping[str, Any]
    seconds: float


def runs_of(resonance_hz: float) -> dict[str, Run]:
    """Return the recorded runs: about the resonance, slow full steps, a sweep of 8 s."""
    rate = round(resonance_hz, 1)
    return {
        "full_res": Run(_command("full", rate=rate), 1.0),
        "full_half": Run(_command("full", rate=round(0.5 * rate, 1)), 1.0),
        "full_slow": Run(_command("full", rate=5.0), 1.0),
        "half_res": Run(_command("half", rate=round(0.7 * rate, 1)), 1.0),
        "micro_res": Run(_command("micro", rate=rate), 1.0),
        "sweep": Run(_command("micro", rate_profile=[[0.0, 0.0], [8.0, round(2.4 * rate, 1)]]), 8.0),
    }


def held_out_of(resonance_hz: float) -> dict[str, Run]:
    """Return the held-out runs: rates and steppings that no record has."""
    shares = (("full", 0.74), ("half", 0.36), ("micro", 1.9))
    return {
        name: Run(_command(stepping, rate=round(share * resonance_hz, 1)), WINDOW_S[1])
        for name, (stepping, share) in zip(HELD_OUT, shares, strict=True)
    }


def _command(stepping: str, **rate: Any) -> dict[str, Any]:
    microsteps = {"microsteps": 16} if stepping == "micro" else {}
    return {"stepping": stepping, **microsteps, **rate, "start_angle_deg": 45.0}


def torque_of(v: Values, one: Run, delay_s: float = 0.0) -> np.ndarray:
    """Return the torque of a run, N m, a sample every 1/RATE_HZ s; the command starts `delay_s` into the record."""
    instants, voltages = edges(one.command, 1.01 * one.seconds)
    angle = math.radians(one.command["start_angle_deg"])
    samples = round(one.seconds * RATE_HZ) + 1
    return run(v, instants, voltages, angle, 1.0 / RATE_HZ, samples, delay_s)
