"""A linear state space, as scipy.signal and python-control hold it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError, UsageError
from mechid.structure.checks import model_findings
from mechid.structure.structure import Structure

GRID_POINTS = 2000
"""Frequencies at which passivity of a state space is looked at."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """x' = A x + B T, rotations = C x + D T; T in N m, rotations in rad, that of the interface first.

    Parameters
    ----------
    A, B, C, D : (n, n), (n, 1), (1 + m, n), (1 + m, 1)
    knows_interface : bool
        Whether the first output is the interface; otherwise its row is zero and its response NaN.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    knows_interface: bool = True

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """All frequencies; above 0 where A is singular, as with rigid-body modes."""
        singular = np.linalg.matrix_rank(self.A) < self.A.shape[0]
        return float(np.nextafter(0.0, 1.0)) if singular else 0.0, math.inf

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return C (i w - A)^-1 B + D, (n_f, 1 + m) rad/(N m); NaN on a pole."""
        out = np.full((frequency_hz.size, self.C.shape[0]), np.nan, dtype=np.complex128)
        for row, f in enumerate(frequency_hz):
            matrix = 2j * np.pi * f * np.eye(self.A.shape[0]) - self.A
            try:
                out[row] = (self.C @ np.linalg.solve(matrix, self.B) + self.D)[:, 0]
            except np.linalg.LinAlgError:
                continue
        if not self.knows_interface:
            out[:, 0] = np.nan
        return out


def from_state_space(
    system: Any,
    line_of_sight: tuple[str, ...],
    *,
    has_interface: bool = True,
    axis: str = "",
    name: str = "state space",
) -> Structure:
    """Return the structure of a state space with attributes A, B, C, D, as scipy.signal's and python-control's.

    Parameters
    ----------
    system : scipy.signal.StateSpace, control.StateSpace or the like
        Continuous; one input, the torque at the interface in N m; outputs in rad.
    line_of_sight : tuple of str, (m,)
        Names of the payload's axes, in the order of the outputs.
    has_interface : bool
        Whether the first output is the rotation of the interface, with the lines of sight after it.
    axis : str
        Axis of the torque, ``"rx"``, ``"ry"`` or ``"rz"``.
    name : str
        What messages call it.

    Raises
    ------
    UsageError
        It is no continuous state space of one input and as many outputs as named.
    InputFileError
        It is not stable.

    Examples
    --------
    >>> import mechid
    >>> from scipy.signal import StateSpace
    >>> body = StateSpace([[0.0, 1.0], [-400.0, -0.4]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.0]])
    >>> mechid.from_state_space(body, ("x",), has_interface=False).line_of_sight
    ('x',)
    """
    if not all(hasattr(system, part) for part in "ABCD"):
        raise UsageError(f"{name}: found {type(system).__name__}; give a state space with A, B, C and D")
    if getattr(system, "dt", None) not in (None, 0, 0.0):
        raise UsageError(f"{name}: is sampled at dt = {system.dt}; give the continuous system")
    A, B, C, D = (np.atleast_2d(np.asarray(getattr(system, part), dtype=np.float64)) for part in "ABCD")
    outputs = len(line_of_sight) + int(has_interface)
    if B.shape[1] != 1 or C.shape[0] != outputs:
        found = f"{B.shape[1]} inputs and {C.shape[0]} outputs"
        raise UsageError(f"{name}: found {found}; it needs one input, the torque, and {outputs} outputs")
    if not has_interface:
        C, D = np.vstack([np.zeros((1, C.shape[1])), C]), np.vstack([np.zeros((1, 1)), D])
    return checked_system(LinearSystem(A, B, C, D, has_interface), line_of_sight, axis, name)


def checked_system(system: LinearSystem, line_of_sight: tuple[str, ...], axis: str, name: str) -> Structure:
    """Return the structure of a system with what its checks found; InputFileError where unstable or not finite."""
    if not all(np.all(np.isfinite(matrix)) for matrix in (system.A, system.B, system.C, system.D)):
        raise InputFileError(f"{name}: a number of A, B, C or D is not finite; write the state space anew")
    poles = np.linalg.eigvals(system.A)
    size = max(float(np.abs(poles).max()), 1.0)
    if poles.real.max() > 1e-6 * size:
        raise InputFileError(f"{name}: has a pole at {poles[poles.real.argmax()]:.6g} rad/s; a structure is stable")
    moving = np.abs(poles[np.abs(poles) > 1e-6 * size]) / (2.0 * np.pi)
    low, high = (moving.min() / 10.0, moving.max() * 10.0) if moving.size else (1e-3, 1e3)
    grid = np.unique(np.concatenate([np.geomspace(low, high, GRID_POINTS), moving]))
    structure = Structure(name=name, line_of_sight=line_of_sight, model=system, axis=axis)
    return structure.with_warnings(*model_findings(grid, system.response(grid)))
