"""A record cut into parts, and the score and information of each: by the phase within a step, and over time.

What a model lacks returns in every step, so that the scores of the phases within a step scatter more than noise lets
them; clusters in time alone do not see it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.target import Target

FloatArray = NDArray[np.float64]
PHASES = 32
"""Parts of a full step of the command."""
STRETCH_S = 0.1
"""About how long a part over time is."""
MOST_STRETCHES = 1024
"""Parts over time of a long record: their number does not grow with it."""
QUARTERS = 4


@dataclass(frozen=True)
class Parts:
    """Score and information of some parts.

    Attributes
    ----------
    scores : (G, n)
        Sum of J^T r over the samples of each part.
    information : (G, n, n)
        Sum of J^T J.
    """

    scores: FloatArray
    information: FloatArray

    @property
    def size(self) -> int:
        """Number of parts, G."""
        return len(self.scores)

    def joined(self, groups: int) -> Parts:
        """Return as many parts as asked for, each made of neighbours; the number is a divisor of the parts'."""
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
        By the phase within a full step; those in which there is a sample. None where no steps are commanded.
    stretches : Parts
        Over time, of equal length: a multiple of four.
    whitened : bool
        Whether what is left of its noise is white, so that chance can be counted.
    """

    name: str
    phases: Parts | None
    stretches: Parts
    whitened: bool


class PartsOfRecord:
    """Sums over the parts of a record, of residuals and Jacobians that come block by block, channel by channel.

    Parameters
    ----------
    target : Target
    time_offset_s : float
        Record time at which its command starts.
    window : (int, int)
        First and last-plus-one sample.
    size : int
        Number of coordinates.
    whitened : bool
    """

    def __init__(
        self, target: Target, time_offset_s: float, window: tuple[int, int], size: int, *, whitened: bool
    ) -> None:
        self._target, self._time_offset_s, self._window = target, time_offset_s, window
        self._done = [window[0]] * len(target.channels)
        seconds = (window[1] - window[0]) / target.base.sample_rate_hz
        of_quarter = np.clip(round(seconds / (QUARTERS * STRETCH_S)), 1, MOST_STRETCHES // QUARTERS)
        stretches = QUARTERS * int(of_quarter)
        self._bounds = np.linspace(*window, stretches + 1).round().astype(np.int64)
        self._stretches = _Sums(stretches, size)
        self._phases = None if isinstance(target.command, MeasuredCommand) else _Sums(PHASES, size)
        self._whitened = whitened

    def add(self, k: int, r: FloatArray, J: FloatArray) -> None:
        """Add the next rows of channel k, (m,) and (m, n)."""
        first = self._done[k]
        self._done[k] = last = first + len(r)
        begun = int(np.searchsorted(self._bounds, first, side="right")) - 1
        cuts = self._bounds[(self._bounds > first) & (self._bounds < last)] - first
        for stretch, part in enumerate(map(slice, [0, *cuts], [*cuts, last - first]), begun):
            self._stretches.add(stretch, r[part], J[part])
        if self._phases is not None:
            phase = self._phase(first, last)
            order = np.argsort(phase, kind="stable")
            r, J = r[order], J[order]
            edges = np.searchsorted(phase[order], np.arange(PHASES + 1))
            for of_step in np.flatnonzero(np.diff(edges)).tolist():
                part = slice(edges[of_step], edges[of_step + 1])
                self._phases.add(of_step, r[part], J[part])

    def _phase(self, first: int, last: int) -> NDArray[np.int64]:
        """Return in which part of a full step the command is at each sample, (m,)."""
        base = self._target.base
        times = base.start_s + np.arange(first, last) / base.sample_rate_hz - self._time_offset_s
        travelled = steps_travelled(self._target.command.rate, times)
        return np.minimum(np.floor(PHASES * (travelled % 1.0)), PHASES - 1).astype(np.int64)

    @property
    def summed(self) -> RecordParts:
        """What they have come to."""
        return RecordParts(
            self._target.name,
            self._phases.parts if self._phases is not None else None,
            self._stretches.every,
            self._whitened,
        )


class _Sums:
    def __init__(self, groups: int, size: int) -> None:
        self._used = np.zeros(groups, dtype=np.bool_)
        self.every = Parts(np.zeros((groups, size)), np.zeros((groups, size, size)))

    def add(self, group: int, r: FloatArray, J: FloatArray) -> None:
        """Add rows to a part."""
        self._used[group] = True
        self.every.scores[group] += J.T @ r
        self.every.information[group] += J.T @ J

    @property
    def parts(self) -> Parts:
        """Those in which there is a sample."""
        return Parts(self.every.scores[self._used], self.every.information[self._used])
