"""How many integration steps a sample needs for the promised accuracy."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.target import Target


def enough_substeps(problem: Problem, q: FloatArray, windows: Windows) -> int:
    """Return the steps a sample, up to 8 times the problem's, that keep every record within the promise at `q`.

    Halving the step cuts the error sixteenfold, so the difference to the halved step is the error.
    The promise is an RMS error of 1e-5 of the RMS of each channel.
    """
    used = [t for t in problem.targets if t.name in windows]
    for _ in range(PROBLEM.most_doublings):
        halved = replace(problem, substeps=2 * problem.substeps)
        if all(_relative_error(problem, halved, t, q, windows[t.name][1]) <= PROBLEM.promised_accuracy for t in used):
            break
        problem = halved
    return problem.substeps


def _relative_error(coarse: Problem, fine: Problem, target: Target, q: FloatArray, stop: int) -> float:
    """Return the RMS difference of two runs over the RMS of the finer one, of the worst channel, block by block."""
    outputs = [coarse.model.output(quantity) for quantity in target.quantities]
    error, size = np.zeros(len(outputs)), np.zeros(len(outputs))
    blocks = zip(coarse.model.run(target, q, stop).blocks(), fine.model.run(target, q, stop).blocks(), strict=True)
    for rough, exact in blocks:
        for k, j in enumerate(outputs):
            error[k] += np.sum((rough.y[:, j] - exact.y[:, j]) ** 2)
            size[k] += np.sum(exact.y[:, j] ** 2)
    return math.sqrt(float(np.max(error / np.maximum(size, 1e-300))))
