"""Linear state-space model with names, units, parameter derivatives and covariance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import UsageError

if TYPE_CHECKING:
    from scipy.signal import StateSpace


@dataclass(frozen=True, eq=False)
class Matrices:
    """Matrices of x' = A x + B u, y = C x + D u, optionally with leading axes for parameters or draws.

    Attributes
    ----------
    A, B, C, D : (..., n, n), (..., n, m), (..., n_y, n), (..., n_y, m)
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    def __getitem__(self, index: Any) -> Matrices:
        """Return the matrices at an index of the leading axes."""
        return Matrices(*(matrix[index] for matrix in self.all))

    @property
    def all(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A, B, C and D."""
        return self.A, self.B, self.C, self.D

    @property
    def block_matrix(self) -> FloatArray:
        """[A B; C D], (..., n + n_y, n + m)."""
        return np.concatenate(
            [np.concatenate([self.A, self.B], axis=-1), np.concatenate([self.C, self.D], axis=-1)], axis=-2
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the matrices as nested lists."""
        return {field.name: getattr(self, field.name).tolist() for field in fields(self)}


@dataclass(frozen=True, eq=False)
class Signals:
    """Names and SI units of the rows or columns of matrices; a unit is empty if unknown."""

    names: tuple[str, ...]
    units: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return names and units."""
        return {"names": list(self.names), "units": list(self.units)}


@dataclass(frozen=True, eq=False)
class Uncertain:
    """Parameters with a covariance, in the units of the mechanism file.

    Attributes
    ----------
    names, units : tuple of str, (k,)
    values : (k,)
    covariance : (k, k)
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray

    @property
    def std_errors(self) -> FloatArray:
        """Standard errors, (k,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), dtype=np.float64)

    def to_dict(self) -> dict[str, Any]:
        """Return names, units, values, standard errors and covariance."""
        return {
            "names": list(self.names),
            "units": list(self.units),
            "values": self.values.tolist(),
            "std_errors": self.std_errors.tolist(),
            "covariance": self.covariance.tolist(),
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearModel:
    """Linear model of a holding mechanism, for small deviations.

    Attributes
    ----------
    name : str
        State of friction: ``"stuck"``, ``"locked"``, ``"free"``, or ``"holding"`` if friction never sticks.
    states, inputs, outputs : Signals
    matrices : Matrices
    x, y : (n,), (n_y,)
        States and outputs of the equilibrium; the model describes deviations from these.
    names : tuple of str, (q,)
        Dotted names of all parameters of the model, in the units of the mechanism file.
    by_parameter : Matrices, (q, ...)
        Total derivatives of the matrices with respect to the parameters, including the shift of the equilibrium.
    uncertain : Uncertain
        Parameters with a covariance.
    limits : mapping of input to (float, float)
        Range of the deviation of each input within the supply.
    margins : mapping of str to float
        Additional torque in N m that each friction holds before it slips, by name.
    samples : Matrices, (N, ...)
        Matrices at draws of the uncertain parameters, each linearised about its own equilibrium.
    draws : (N, k)
        Draws of the uncertain parameters.
    """

    name: str
    states: Signals
    inputs: Signals
    outputs: Signals
    matrices: Matrices
    x: FloatArray
    y: FloatArray
    names: tuple[str, ...]
    by_parameter: Matrices
    uncertain: Uncertain
    limits: Mapping[str, tuple[float, float]]
    margins: Mapping[str, float]
    samples: Matrices
    draws: FloatArray

    @cached_property
    def by_uncertain(self) -> Matrices:
        """Derivatives of the matrices with respect to the uncertain parameters, (k, ...)."""
        return self.by_parameter[[self.names.index(name) for name in self.uncertain.names]]

    def response(self, frequency_hz: Sequence[float] | FloatArray) -> ComplexArray:
        """Return the frequency response at positive frequencies, (f, n_y, m), in units of outputs over inputs."""
        return response_of(self.matrices, frequency_hz)

    def amplitude_sigma(self, frequency_hz: Sequence[float] | FloatArray) -> FloatArray:
        """Return the standard error of the amplitude response, (f, n_y, m), propagated from the covariance."""
        here = self.response(frequency_hz)
        # The amplitude changes along the phase of the response; the least value guards against 0 / 0.
        unit = here / np.maximum(np.abs(here), 1e-300)
        slopes = (np.conj(unit) * self._slopes(frequency_hz)).real
        square = np.einsum("i...,ij,j...->...", slopes, self.uncertain.covariance, slopes)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)), dtype=np.float64)

    def _slopes(self, frequency_hz: Sequence[float] | FloatArray) -> ComplexArray:
        """Return the derivatives of the response with respect to the uncertain parameters, (k, f, n_y, m)."""
        A, B, C, _ = self.matrices.all
        M = _shift(A, frequency_hz)
        # d(M^-1) = M^-1 dA M^-1 with M = i w - A: two solves serve all parameters.
        right = np.linalg.solve(M, np.broadcast_to(B + 0j, (len(M), *B.shape)))
        left = np.linalg.solve(np.swapaxes(M, 1, 2), np.broadcast_to(C.T + 0j, (len(M), *C.T.shape))).swapaxes(1, 2)
        moved = self.by_uncertain
        each = [c @ right + left @ (a @ right + b) + d for a, b, c, d in zip(*moved.all, strict=True)]
        return np.array(each, dtype=np.complex128).reshape(-1, *self.response(frequency_hz).shape)

    def to_scipy(self) -> StateSpace:
        """Convert to SciPy's StateSpace, which has no names."""
        from scipy.signal import StateSpace

        return StateSpace(*self.matrices.all)

    def to_control(self) -> Any:
        """Convert to python-control's StateSpace, with names of states, inputs and outputs.

        Raises
        ------
        UsageError
            python-control is not installed.
        """
        try:
            from control import StateSpace
        except ImportError as error:
            raise UsageError('python-control is not installed; pip install "mechid[control]"') from error
        return StateSpace(*self.matrices.all, **self.control_names())

    def control_names(self) -> dict[str, Any]:
        """Return the keyword arguments of python-control's StateSpace besides A, B, C and D."""
        return {
            "name": self.name,
            "states": list(self.states.names),
            "inputs": list(self.inputs.names),
            "outputs": list(self.outputs.names),
        }

    def to_dict(self) -> dict[str, Any]:
        """Return the model as lists and plain numbers."""
        return {
            "states": self.states.to_dict(),
            "inputs": self.inputs.to_dict(),
            "outputs": self.outputs.to_dict(),
            **self.matrices.to_dict(),
            "x": self.x.tolist(),
            "y": self.y.tolist(),
            "limits": {name: list(limit) for name, limit in self.limits.items()},
            "margins": dict(self.margins),
            "parameters": list(self.names),
            "by_parameter": self.by_parameter.to_dict(),
            "samples": self.samples.to_dict(),
        }


def response_of(matrices: Matrices, frequency_hz: Sequence[float] | FloatArray) -> ComplexArray:
    """Return C (i w - A)^-1 B + D, (f, n_y, m), at positive frequencies."""
    A, B, C, D = matrices.all
    M = _shift(A, frequency_hz)
    resolved = np.linalg.solve(M, np.broadcast_to(B + 0j, (len(M), *B.shape)))
    return np.asarray(C @ resolved + D, dtype=np.complex128)


def _shift(A: FloatArray, frequency_hz: Sequence[float] | FloatArray) -> ComplexArray:
    """Return i w - A, (f, n, n)."""
    w = 2.0 * np.pi * np.asarray(frequency_hz, dtype=np.float64)
    return np.asarray(1j * w[:, None, None] * np.eye(len(A)) - A, dtype=np.complex128)
