"""Target of ``mechid export --to linear``: linear.json, linear.mat and mechid_uss.m, read back and verified."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from mechid.errors import FitError
from mechid.exports.export import TargetOutput, Verification
from mechid.exports.handover import Handover
from mechid.exports.linear.check import FREQUENCIES_HZ, departure
from mechid.exports.linear.linear import Linear, linear_of
from mechid.exports.linear.mat import UNCERTAIN_SS, write_mat
from mechid.exports.linear.options import Options
from mechid.exports.linear.state_space import Matrices
from mechid.identification.result.estimate_file import json_text
from mechid.writing import write_atomically

JSON, MAT, FUNCTION = FILES = ("linear.json", "linear.mat", "mechid_uss.m")
# Integration errors and the remaining nonlinearity of a small sine stay below this.
AGREES = 1e-4
"""Largest deviation of a model from the equations, relative to its response."""


def write_target(handover: Handover, folder: Path, options: Options | None = None) -> TargetOutput:
    """Write the linear models of a handover into a folder.

    Raises
    ------
    InputFileError
        No step command drives the mechanism, or a changed value is impossible.
    UsageError
        An option is invalid.
    FitError
        A model cannot be made, or deviates from the equations.
    """
    linear = linear_of(handover, options)
    write_atomically(folder / JSON, json_text(linear.to_dict(), indent=None))
    write_mat(linear, folder / MAT)
    write_atomically(folder / FUNCTION, UNCERTAIN_SS)
    return TargetOutput(FILES, _check(linear, folder), linear.words, tuple(_figures(linear)))


def _check(linear: Linear, folder: Path) -> Verification:
    """Compare the models of both files with the nonlinear equations, and return their largest deviation."""
    from_mat = loadmat(folder / MAT)
    from_json = json.loads((folder / JSON).read_text(encoding="utf-8"))["models"]
    off = []
    for name in linear.models:
        here = _matrices(from_mat[name][0, 0])
        # Both files have to contain the same bits, also on a full disk.
        if not all(np.array_equal(a, b) for a, b in zip(here.all, _matrices(from_json[name]).all, strict=True)):
            raise FitError(f"{JSON} and {MAT} do not hold the same model {name}; the disk may be full: export anew")
        off.append(departure(linear.held, name, here))
    if max(off) > AGREES:
        raise FitError(
            f"a linear model leaves the nonlinear equations by {max(off):.2g} of its response, more than {AGREES:g}: "
            "the mechanism is not linear at its rest point, as at the edge of a gear's slope; hold it at another start "
            "angle"
        )
    hertz = ", ".join(f"{f:g}" for f in FREQUENCIES_HZ)
    against = f"the nonlinear equations in time, a small sine of {hertz} Hz into each input; relative to the response"
    return Verification(against, max(off), float(np.sqrt(np.mean(np.square(off)))))


def _figures(linear: Linear) -> Iterator[Any]:
    if linear.loops:
        # Imported here, since Matplotlib takes half a second to load.
        from mechid.exports.linear.loops.figures import loop_figures

        yield from loop_figures(linear.loops)


def _matrices(found: Any) -> Matrices:
    """Read matrices; a model without states, as of a stuck motor on a current drive, has empty ones."""
    A, B, C, D = (np.array(found[name], dtype=np.float64) for name in "ABCD")
    n = len(B)
    return Matrices(A.reshape(n, n), B.reshape(n, D.shape[1]), C.reshape(len(D), n), D)
