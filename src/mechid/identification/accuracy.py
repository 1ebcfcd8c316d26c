"""How many integration steps a sample needs for the promised accuracy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.identification.problem import Problem, Windows

FloatArray = NDArray[np.float64]
PROMISE = 1e-5
MOST_DOUBLINGS = 3


def enough_substeps(problem: Problem, q: FloatArray, windows: Windows) -> int:
    """Return the steps a sample, up to 8 times the problem's, that keep every record within the promise at `q`.

    Halving the step cuts the error sixteenfold, so the difference to the halved step is the error.
    The promise is an RMS error of 1e-5 of the record's RMS torque.
    """
    substeps = problem.substeps
    coarse = _predictions(replace(problem, substeps=substeps), q, windows)
    for _ in range(MOST_DOUBLINGS):
        fine = _predictions(replace(problem, substeps=2 * substeps), q, windows)
        if all(_relative_error(c, f) <= PROMISE for c, f in zip(coarse, fine, strict=True)):
            break
        substeps, coarse = 2 * substeps, fine
    return substeps


def _relative_error(coarse: FloatArray, fine: FloatArray) -> float:
    size = float(np.sqrt(np.mean(fine**2)))
    return float(np.sqrt(np.mean((coarse - fine) ** 2))) / max(size, 1e-300)


def _predictions(problem: Problem, q: FloatArray, windows: Windows) -> list[FloatArray]:
    used = [t for t in problem.targets if t.name in windows]
    return [problem.predict(t, q, windows[t.name][1]) for t in used]
