"""Sampled linear systems: exact discretisation with a held, delayed input, lifting to a slower rate, feedback.

A plant x' = A x + B u whose input is held from each sample on, late by d samples and a fraction f of the period T, is
sampled exactly by

    x[k+1] = Phi(T) x[k] + Gamma_0 u[k-d] + Gamma_1 u[k-d-1],
    Gamma_0 = Gamma(T - f T),  Gamma_1 = Phi(T - f T) Gamma(f T),

with Phi(t) = exp(A t) and Gamma(t) the integral of exp(A s) B over 0..t (K. J. Astrom, B. Wittenmark,
Computer-Controlled Systems, 3rd ed., 1997, section 2.3). Earlier inputs are further states.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from mechid.arrays import ComplexArray, FloatArray
from mechid.exports.linear.state_space import Matrices

ROUNDING = 1e-9
"""Fraction of a sample below which a delay is a whole number of samples."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """System x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k], sampled each `period_s`.

    Attributes
    ----------
    matrices : Matrices
    period_s : float
    inputs, outputs : tuple of str
        Names of the columns and rows.
    """

    matrices: Matrices
    period_s: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def nyquist_hz(self) -> float:
        """Half the sample rate, Hz."""
        return 0.5 / self.period_s

    @property
    def poles(self) -> ComplexArray:
        """Eigenvalues of A in the z plane, (n,)."""
        return np.asarray(np.linalg.eigvals(self.matrices.A), dtype=np.complex128)

    def select(self, inputs: Sequence[str], outputs: Sequence[str]) -> Sampled:
        """Return the system between some inputs and outputs; all states are kept."""
        columns = [self.inputs.index(name) for name in inputs]
        rows = [self.outputs.index(name) for name in outputs]
        A, B, C, D = self.matrices.all
        return replace(
            self,
            matrices=Matrices(A, B[:, columns], C[rows], D[np.ix_(rows, columns)]),
            inputs=tuple(inputs),
            outputs=tuple(outputs),
        )

    def combine_inputs(self, name: str, weights: Sequence[tuple[str, float]]) -> Sampled:
        """Return the system with one more input that drives others with weights."""
        A, B, C, D = self.matrices.all
        mix = np.zeros(len(self.inputs))
        for own, weight in weights:
            mix[self.inputs.index(own)] = weight
        matrices = Matrices(A, np.column_stack([B, B @ mix]), C, np.column_stack([D, D @ mix]))
        return replace(self, matrices=matrices, inputs=(*self.inputs, name))

    def response(self, frequency_hz: Sequence[float] | FloatArray) -> ComplexArray:
        """Return the frequency response, (f, n_y, m), up to half the sample rate."""
        A, B, C, D = self.matrices.all
        z = np.exp(2j * np.pi * self.period_s * np.asarray(frequency_hz, dtype=np.float64))
        shifted = z[:, None, None] * np.eye(len(A)) - A
        return np.asarray(C @ np.linalg.solve(shifted, np.broadcast_to(B + 0j, (len(z), *B.shape))) + D)


def hold(
    plant: Matrices,
    inputs: Sequence[str],
    outputs: Sequence[str],
    period_s: float,
    *,
    delayed: Sequence[str] = (),
    delay_s: float = 0.0,
) -> Sampled:
    """Sample a continuous system with held inputs, of which `delayed` act `delay_s` late."""
    columns = [list(inputs).index(name) for name in delayed]
    whole, late = _split(delay_s / period_s)
    phi, gamma = _flow(plant, period_s)
    early, new = _flow(plant, period_s * (1.0 - late))
    old = early @ _flow(plant, period_s * late)[1]
    matrices = _delay(Matrices(phi, gamma, plant.C, plant.D), new, old, columns, whole, late > 0.0)
    return Sampled(matrices, period_s, tuple(inputs), tuple(outputs))


def lift(system: Sampled, every: int, *, delayed: Sequence[str] = (), delay: int = 0) -> Sampled:
    """Return a system at each `every`-th sample, with inputs held in between; `delayed` act `delay` samples late."""
    columns = [system.inputs.index(name) for name in delayed]
    whole, late = divmod(delay, every)
    A, B, C, D = system.matrices.all
    powers = [np.linalg.matrix_power(A, 0)]
    for _ in range(every):
        powers.append(powers[-1] @ A)
    sums = np.cumsum([np.zeros_like(A), *powers[:every]], axis=0)
    new, old = sums[every - late] @ B, powers[every - late] @ sums[late] @ B
    matrices = _delay(Matrices(powers[every], sums[every] @ B, C, D), new, old, columns, whole, late > 0)
    return replace(system, matrices=matrices, period_s=system.period_s * every)


def close(plant: Sampled, controller: Sampled, references: Sequence[str]) -> Sampled:
    """Close a controller around a plant.

    The controller's inputs are errors of the plant's outputs of these names, its outputs drive the plant's inputs of
    these names in addition to what acts there.

    Parameters
    ----------
    plant, controller : Sampled
    references : sequence of str
        Names of the references, which come before the inputs of the plant.

    Returns
    -------
    Sampled
        With the outputs of the plant, and after these the controller's, named ``"control_"`` and the input it drives.
    """
    A, B, C, D = plant.matrices.all
    Ac, Bc, Cc, Dc = controller.matrices.all
    M = np.eye(len(plant.outputs))[[plant.outputs.index(name) for name in controller.inputs]]
    S = np.eye(len(plant.inputs))[:, [plant.inputs.index(name) for name in controller.outputs]]
    # Sampled outputs do not jump with the input of the same instant, so there is no algebraic loop.
    assert not np.any(M @ D)
    MC, BS, DS = M @ C, B @ S, D @ S
    m = len(references)
    closed = Matrices(
        np.block([[A - BS @ Dc @ MC, BS @ Cc], [-Bc @ MC, Ac]]),
        np.block([[BS @ Dc, B], [Bc, np.zeros((len(Ac), B.shape[1]))]]),
        np.block([[C - DS @ Dc @ MC, DS @ Cc], [-Dc @ MC, Cc]]),
        np.block([[DS @ Dc, D], [Dc, np.zeros((len(Cc), D.shape[1]))]]),
    )
    assert closed.B.shape[1] == m + len(plant.inputs)
    outputs = (*plant.outputs, *(f"control_{name}" for name in controller.outputs))
    return Sampled(closed, plant.period_s, (*references, *plant.inputs), outputs)


def series(first: Sampled, second: Sampled) -> Sampled:
    """Return the second system behind the first, whose outputs are its inputs in their order."""
    A1, B1, C1, D1 = first.matrices.all
    A2, B2, C2, D2 = second.matrices.all
    joined = Matrices(
        np.block([[A1, np.zeros((len(A1), len(A2)))], [B2 @ C1, A2]]),
        np.vstack([B1, B2 @ D1]),
        np.hstack([D2 @ C1, C2]),
        D2 @ D1,
    )
    return Sampled(joined, first.period_s, first.inputs, second.outputs)


def _split(samples: float) -> tuple[int, float]:
    """Return a delay as whole samples and a fraction."""
    whole = math.floor(samples + ROUNDING)
    late = samples - whole
    return whole, late if late > ROUNDING else 0.0


def _flow(plant: Matrices, time_s: float) -> tuple[FloatArray, FloatArray]:
    """Return exp(A t) and the integral of exp(A s) B over 0..t."""
    n, m = plant.B.shape
    both = np.zeros((n + m, n + m))
    both[:n, :n], both[:n, n:] = plant.A, plant.B
    flow = expm(both * time_s)
    return flow[:n, :n], flow[:n, n:]


def _delay(
    of: Matrices, new: FloatArray, old: FloatArray, columns: Sequence[int], whole: int, is_late: bool
) -> Matrices:
    """Add the earlier inputs of some columns as states: the newest first.

    Parameters
    ----------
    of : Matrices
        Sampled matrices without delay.
    new, old : (n, m)
        Effects of the inputs `whole` and `whole` + 1 samples earlier; `old` is 0 unless `is_late`.
    """
    n, m = of.B.shape
    earlier, width = whole + is_late, len(columns)
    size = n + earlier * width
    A, B, C, D = np.zeros((size, size)), np.zeros((size, m)), np.zeros((len(of.C), size)), of.D.copy()
    A[:n, :n], B[:n], C[:, :n] = of.A, of.B, of.C

    def place(back: int) -> slice:
        return slice(n + (back - 1) * width, n + back * width)

    B[:n, columns] = 0.0
    if whole == 0:
        B[:n, columns] = new[:, columns]
    else:
        A[:n, place(whole)] = new[:, columns]
    if is_late:
        A[:n, place(whole + 1)] += old[:, columns]
    if earlier:
        # At the sample itself the oldest input still acts.
        C[:, place(earlier)] = D[:, columns]
        D[:, columns] = 0.0
        B[place(1), columns] = np.eye(width)
        for back in range(2, earlier + 1):
            A[place(back), place(back - 1)] = np.eye(width)
    return Matrices(A, B, C, D)
