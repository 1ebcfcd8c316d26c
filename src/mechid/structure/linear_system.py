"""Linear state-space models, compatible with scipy.signal and python-control."""

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
"""Number of frequencies of the passivity check of a state space."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """State space x' = A x + B T, rotations = C x + D T; T in N m, rotations in rad, that of the interface first.

    Parameters
    ----------
    A, B, C, D : (n, n), (n, 1), (1 + m, n), (1 + m, 1)
    knows_interface : bool
        Whether the first output is the rotation of the interface; otherwise its row is zero and its response NaN.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    knows_interface: bool = True

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """All frequencies, without 0 if A is singular, for example with rigid-body modes."""
        singular = np.linalg.matrix_rank(self.A) < self.A.shape[0]
        return float(np.nextafter(0.0, 1.0)) if singular else 0.0, math.inf

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return C (i w - A)^-1 B + D, (n_f, 1 + m) rad/(N m); NaN at a pole."""
        out = np.full((frequency_hz.size, self.C.shape[0]), np.nan, dtype=np.complex128)
        for row, f in enumerate(frequency_hz):
            matrix = 2j * np.pi * f * np.eye(self.A.shape[0]) - self.A
            # Solved one by one: a singular matrix at a pole must not lose the other frequencies.
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
    """Return the structure of a state space with attributes A, B, C, D, as in scipy.signal and python-control.

    Parameters
    ----------
    system : scipy.signal.StateSpace, control.StateSpace or similar
        Continuous-time system with one input, the torque at the interface in N m, and outputs in rad.
    line_of_sight : tuple of str, (m,)
        Names of the payload's axes, in the order of the outputs.
    has_interface : bool
        Whether the first output is the rotation of the interface, followed by the lines of sight.
    axis : str
        Axis of the torque, ``"rx"``, ``"ry"`` or ``"rz"``.
    name : str
        Name used in messages.

    Raises
    ------
    UsageError
        The system is not a continuous-time state space with one input and the named outputs.
    InputFileError
        The system is unstable.

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
        raise UsageError(f"{name}: is discrete with dt = {system.dt}; give the continuous-time system")
    A, B, C, D = (np.atleast_2d(np.asarray(getattr(system, part), dtype=np.float64)) for part in "ABCD")
    outputs = len(line_of_sight) + int(has_interface)
    if B.shape[1] != 1 or C.shape[0] != outputs:
        found = f"{B.shape[1]} inputs and {C.shape[0]} outputs"
        raise UsageError(f"{name}: found {found}; give a system with one input, the torque, and {outputs} outputs")
    if not has_interface:
        C, D = np.vstack([np.zeros((1, C.shape[1])), C]), np.vstack([np.zeros((1, 1)), D])
    return check_system(LinearSystem(A, B, C, D, has_interface), line_of_sight, axis, name)


def check_system(system: LinearSystem, line_of_sight: tuple[str, ...], axis: str, name: str) -> Structure:
    """Return the structure of a system with warnings of its checks; raise InputFileError if unstable or not finite."""
    if not all(np.all(np.isfinite(matrix)) for matrix in (system.A, system.B, system.C, system.D)):
        raise InputFileError(f"{name}: a number of A, B, C or D is not finite; export the state space again")
    poles = np.linalg.eigvals(system.A)
    # Rigid-body poles at zero are computed with rounding errors of either sign, relative to the largest pole.
    size = max(float(np.abs(poles).max()), 1.0)
    if poles.real.max() > 1e-6 * size:
        raise InputFileError(
            f"{name}: has an unstable pole at {poles[poles.real.argmax()]:.6g} rad/s; give a stable structure"
        )
    # The grid spans a decade around the poles and includes them, since resonances may be narrower than its spacing.
    moving = np.abs(poles[np.abs(poles) > 1e-6 * size]) / (2.0 * np.pi)
    low, high = (moving.min() / 10.0, moving.max() * 10.0) if moving.size else (1e-3, 1e3)
    grid = np.unique(np.concatenate([np.geomspace(low, high, GRID_POINTS), moving]))
    structure = Structure(name=name, line_of_sight=line_of_sight, model=system, axis=axis)
    return structure.with_warnings(*model_findings(grid, system.response(grid)))
