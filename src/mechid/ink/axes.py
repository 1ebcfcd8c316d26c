"""Helpers for plots of results: axes, curves over time, labels, and selection by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from mechid.errors import UsageError, did_you_mean
from mechid.ink.extremes import Times, reduce_to_extremes
from mechid.ink.quantities import TIME, quantity_words
from mechid.units import unit_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Clock(NamedTuple):
    """Sample rate in Hz and record time of the first sample in s."""

    sample_rate_hz: float
    start_s: float


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the given axes, else new ones."""
    if ax is not None:
        return ax
    # Imported here, since it takes half a second to load.
    from matplotlib import pyplot

    return pyplot.subplots(figsize=(6.9, 3.2), layout="constrained")[1]


def draw_over_time(axes: Axes, samples: Any, clock: Times, quantity: str, **style: Any) -> None:
    """Draw a quantity over time, reduced to extremes if there are more samples than columns of the picture."""
    axes.plot(*reduce_to_extremes(samples, clock), **style)
    axes.set_xlabel(TIME)
    axes.set_ylabel(f"{quantity_words(quantity)}, {unit_words(quantity)}")


def one_of(name: str | None, known: Iterable[str], kind: str) -> str:
    """Return a known name, by default the first.

    Raises
    ------
    UsageError
        The name is unknown.
    """
    names = list(known)
    if name is None:
        return names[0]
    if name not in names:
        near = did_you_mean(name, names) or "; there are " + ", ".join(names)
        raise UsageError(f'plot: no {kind} "{name}"{near}')
    return name
