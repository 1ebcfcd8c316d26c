"""Noise of each record: held at its high-frequency floor during the search, released at the end."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mechid.identification.problem import Problem, Windows
from mechid.identification.uncertainty import residual

FloatArray = NDArray[np.float64]
MISFIT = 1.2


def released_sigmas(problem: Problem, q: FloatArray, windows: Windows, warnings: list[str]) -> dict[str, float]:
    """Return each record's residual RMS as its sigma, unless that is a misfit.

    A record whose residual is more than 1.2 times its own noise floor keeps the floor, so that it is not
    weighted away, and `warnings` gets a line.
    """
    sigmas: dict[str, float] = {}
    for target in problem.targets:
        if target.name not in windows:
            continue
        r = residual(problem, target, q, windows[target.name])
        rms = float(np.linalg.norm(r)) / math.sqrt(r.size)
        if rms > MISFIT * target.sigma:
            warnings.append(
                f"record {target.name}: the residual is {rms:.3g} N m RMS, {rms / target.sigma:.2f} times the record's "
                f"noise floor {target.sigma:.3g} N m: the model lacks something that this record contains"
            )
        else:
            sigmas[target.name] = rms
    return sigmas
