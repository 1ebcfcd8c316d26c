"""Parts of a record, by phase within a step and over time, with the score and information of each.

A model error repeats in every step, so the scores of the phases within a step scatter more than noise explains.
Clusters in time alone do not show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command import MeasuredCommand, Timing
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.target import Target
from mechid.identification.uncertainty.settings import ERRORS


@dataclass(frozen=True)
class Parts:
    """Score and information of a set of parts.

    Attributes
    ----------
    scores : (G, n)
        Sum of J^T r over the samples of each part.
    information : (G, n, n)
        Sum of J^T J over the samples of each part.
    """

    scores: FloatArray
    information: FloatArray

    @property
    def size(self) -> int:
        """Number of parts, G."""
        return len(self.scores)

    @property
    def informative(self) -> Parts:
        """The parts that carry information on at least one coordinate."""
        some = np.trace(self.information, axis1=1, axis2=2) > 0.0
        return Parts(self.scores[some], self.information[some])

    def merge(self, groups: int) -> Parts:
        """Merge neighbouring parts into `groups` parts; `groups` divides the number of parts."""
        n = self.scores.shape[1]
        return Parts(
            self.scores.reshape(groups, -1, n).sum(axis=1), self.information.reshape(groups, -1, n, n).sum(axis=1)
        )


@dataclass(frozen=True)
class RecordParts:
    """The parts of one record.

    Attributes
    ----------
    name : str
    phases : Parts or None
        Parts by the phase within a full step, without those that have no sample. None where no steps are commanded.
    stretches : Parts
        Parts of equal length over time; their number is a multiple of four.
    whitened : bool
        Whether the remaining noise is white, so that the scatter by chance can be computed.
    """

    name: str
    phases: Parts | None
    stretches: Parts
    whitened: bool


class PartsAccumulator:
    """Sums of products of [Phi r J] over the parts of a record; the columns arrive block by block for each channel.

    Parameters
    ----------
    target : Target
    timing : Timing
        Map from record time to command time.
    window : (int, int)
        First and last-plus-one sample.
    widths : sequence of int
        Columns of each channel.
    whitened : bool
    """

    def __init__(
        self,
        target: Target,
        timing: Timing,
        window: tuple[int, int],
        widths: Sequence[int],
        *,
        whitened: bool,
    ) -> None:
        self._target, self._timing = target, timing
        self._done = [window[0]] * len(target.channels)
        seconds = (window[1] - window[0]) / target.base.sample_rate_hz
        # Stretches come in multiples of four, so that they merge into quarters of the record.
        of_quarter = np.clip(
            round(seconds / (ERRORS.quarters * ERRORS.stretch_s)), 1, ERRORS.most_stretches // ERRORS.quarters
        )
        stretches = ERRORS.quarters * int(of_quarter)
        self._bounds = np.linspace(*window, stretches + 1).round().astype(np.int64)
        stepped = not isinstance(target.command, MeasuredCommand)
        self._stretches = [np.zeros((stretches, width, width)) for width in widths]
        self._phases = [np.zeros((ERRORS.phases, width, width)) for width in widths] if stepped else None
        self._whitened = whitened

    def add(self, k: int, rows: FloatArray) -> None:
        """Add the next samples of channel k, (width, m)."""
        first = self._done[k]
        self._done[k] = last = first + rows.shape[1]
        begun = int(np.searchsorted(self._bounds, first, side="right")) - 1
        cuts = self._bounds[(self._bounds > first) & (self._bounds < last)] - first
        for stretch, part in enumerate(map(slice, [0, *cuts], [*cuts, last - first]), begun):
            self._stretches[k][stretch] += rows[:, part] @ rows[:, part].T
        if self._phases is not None:
            phase = self._phase(first, last)
            # Sorted by phase, each phase is one contiguous slice and one matrix product.
            rows = rows[:, np.argsort(phase, kind="stable")]
            ends = np.cumsum(np.bincount(phase, minlength=ERRORS.phases))
            for of_step, part in enumerate(map(slice, [0, *ends[:-1]], ends)):
                self._phases[k][of_step] += rows[:, part] @ rows[:, part].T

    def _phase(self, first: int, last: int) -> IntArray:
        """Return the phase of the command within its full step at each sample, (m,)."""
        base = self._target.base
        times = base.start_s + np.arange(first, last) / base.sample_rate_hz
        travelled = steps_travelled(self._target.command.rate, self._timing.command_s(times))
        return np.minimum(np.floor(ERRORS.phases * (travelled % 1.0)), ERRORS.phases - 1).astype(np.int64)

    @property
    def projections(self) -> list[FloatArray]:
        """Maps from each channel's columns to residual and Jacobian in sigmas, offset and drift removed.

        Each is of shape (width, 1 + n).
        """
        return [
            _projection(products.sum(axis=0), channel.projected_columns) / channel.scale
            for channel, products in zip(self._target.channels, self._stretches, strict=True)
        ]

    def sum_parts(self, projections: Sequence[FloatArray]) -> RecordParts:
        """Return the parts of the record; `projections` maps each channel's columns to residual and Jacobian."""
        phases = _sum_channels(self._phases, projections) if self._phases is not None else None
        return RecordParts(
            self._target.name,
            phases and phases.informative,
            _sum_channels(self._stretches, projections),
            self._whitened,
        )


def _projection(products: FloatArray, linear: int) -> FloatArray:
    """Return the map from columns [Phi r J] to residual and Jacobian with Phi projected out, (width, 1 + n)."""
    rest = np.eye(len(products) - linear)
    if not linear:
        return rest
    return np.vstack([-np.linalg.solve(products[:linear, :linear], products[:linear, linear:]), rest])


def _sum_channels(products: Sequence[FloatArray], projections: Sequence[FloatArray]) -> Parts:
    """Sum the parts over channels from the products of their columns, (G, width, width) each."""
    every = sum(of.T @ own @ of for own, of in zip(products, projections, strict=True))
    found = np.asarray(every, dtype=np.float64)
    return Parts(found[:, 0, 1:], found[:, 1:, 1:])
