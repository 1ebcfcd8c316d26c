"""Errors of sources other than the mechanism: the user's bias, random and periodic entries of the budget."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.indices import Index
from mechid.budgets.pointing_error import FlatRandom, PointingError, Source, flat_share
from mechid.budgets.summation import KINDS, Contribution
from mechid.errors import UsageError


@dataclass(frozen=True, kw_only=True, eq=False)
class OtherError:
    """Error of another source along the lines of sight.

    Parameters
    ----------
    name : str
    kind : str
        "bias", "random" (size: standard deviation over time) or "periodic" (size: amplitude).
    axes : (m,) bool
        Lines of sight along which it acts.
    size_rad, spread_rad : float
        Mean and standard deviation of the size over the ensemble.
    frequency_hz : float
        Of a periodic error.
    bandwidth_hz : float
        Of a random error, whose density is flat up to this frequency.
    group : str
        Errors of one group are fully correlated in the ECSS sum and drawn together; empty for an independent error.

    Raises
    ------
    UsageError
        The kind is unknown.
    """

    name: str
    kind: str
    axes: BoolArray
    size_rad: float
    spread_rad: float = 0.0
    frequency_hz: float = 0.0
    bandwidth_hz: float = 0.0
    group: str = ""

    def __post_init__(self) -> None:
        if self.kind not in _ADDERS:
            raise UsageError(f'{self.name}: unknown kind "{self.kind}"; write one of {", ".join(KINDS)}')

    def add_to(self, error: PointingError, draw: float) -> PointingError:
        """Return a pointing error with this one added, its size `draw` standard deviations from its mean."""
        return _ADDERS[self.kind](error, self, np.where(self.axes, self.size_rad + draw * self.spread_rad, 0.0))

    def contribution(self, index: Index, axis: int) -> Contribution | None:
        """Return the contribution along an axis for the ECSS sum, as the index keeps it; None if it is zero."""
        kept = _KEPT_SHARES[self.kind](self, index) if self.axes[axis] else 0.0
        if kept == 0.0:
            return None
        return Contribution(
            name=self.name,
            kind=self.kind,
            size=kept * self.size_rad,
            spread=abs(kept) * self.spread_rad,
            group=self.group,
        )


def _with_bias(error: PointingError, source: OtherError, size: FloatArray) -> PointingError:
    del source
    return replace(error, bias=error.bias + size)


def _with_noise(error: PointingError, source: OtherError, size: FloatArray) -> PointingError:
    return replace(error, randoms=(*error.randoms, FlatRandom(source.bandwidth_hz, size)))


def _with_line(error: PointingError, source: OtherError, size: FloatArray) -> PointingError:
    line = Source(source.name, source.frequency_hz, np.array([1.0]), size[None, :].astype(np.complex128))
    return replace(error, parts=(*error.parts, line))


_ADDERS = {"bias": _with_bias, "random": _with_noise, "periodic": _with_line}
_KEPT_SHARES: dict[str, Callable[[OtherError, Index], float]] = {
    "bias": lambda _, index: index.bias_gain,
    "random": lambda source, index: float(np.sqrt(flat_share(index, source.bandwidth_hz))),
    "periodic": lambda source, index: float(np.sqrt(index.weight(np.array([source.frequency_hz]))[0])),
}
"""Share that an index keeps, by kind. A kind without an entry is refused instead of treated as another."""
