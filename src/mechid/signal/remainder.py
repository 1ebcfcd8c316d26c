"""Remainder of a series after subtraction of offset, drift and a model, computed on access."""

from __future__ import annotations

from dataclasses import dataclass, field

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, no_samples
from mechid.signal.trend import Line


@dataclass(frozen=True, eq=False)
class Remainder:
    """Series minus a line and a model, computed on access, in the series' unit.

    Attributes
    ----------
    series : Series
    line : Line
    model : Series or None
    rejected : (s,) of int
        Indices of rejected samples, ascending, at which the remainder is 0.

    Examples
    --------
    >>> import numpy as np
    >>> Remainder(np.array([1.0, 2.0, 4.0]), Line(1.0, 1.0))[1:]
    array([0., 1.])
    """

    series: Series
    line: Line = field(default_factory=Line)
    model: Series | None = None
    rejected: IntArray = field(default_factory=no_samples)

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.series.size

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the samples of a slice with a positive step."""
        start, stop, step = part.indices(self.size)
        left = self.series[part] - self.line.at(start, stop, step)
        if self.model is not None:
            left -= self.model[part]
        inside = self.rejected[(self.rejected >= start) & (self.rejected < stop)] - start
        left[inside[inside % step == 0] // step] = 0.0
        return left
