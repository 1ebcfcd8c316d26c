r"""Pointing error indices, one row each: definition on a time series and weight on a spectrum.

ECSS-E-ST-60-10C, 3.2, defines them in time, on an error e(t) and a window of T around it:

- APE, absolute: e(t)
- MPE, mean: the mean of e over a window
- RPE, relative: e(t) less its mean over the window that holds t
- PDE, drift: the difference of two means, their windows a separation apart in one observation period
- PRE, reproducibility: the same of windows in different observation periods

Each index is written once, as the `form` of its row, in terms of an error at an instant and of its means. Evaluated on
a sampled series, the form is the index itself (`Index.in_time`); evaluated on a line, it is the gain of the line's
phasor (`Index.gains`). For a stationary error the variance of each is the integral of its spectrum by a weight, with s
= sin(pi f T)/(pi f T) [Lucke1992]_, which ESSB-HB-E-003, 8.2, takes over:

    APE 1,   MPE s^2,   RPE 1 - s^2,   PDE and PRE 4 sin^2(pi f S) s^2

The weight is the mean of the squared gain over the instants of a window; a test checks this for every row. Only RPE's
squared gain depends on the instant: at tau from the window's centre it is 1 + s^2 - 2 s cos(2 pi f tau), which a
distribution needs.

.. [Lucke1992] Lucke, Sirlin, San Martin, New Definitions of Pointing Stability: AC and DC Effects, The Journal of the
   Astronautical Sciences 40(4), 1992.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.errors import InputFileError, did_you_mean

AnyArray = NDArray[Any]


class WindowedError(Protocol):
    """Error as an index evaluates it in a window; a form is written in these terms and is linear in them."""

    def instant(self) -> AnyArray:
        """Return the error at an instant in the window."""

    def mean(self, later: int = 0) -> AnyArray:
        """Return the mean over the window, or over the window a number of separations later."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Definition of an index.

    Parameters
    ----------
    name, words : str
        Name in a budget file; a short description.
    form : callable
        Index as a function of the windowed error.
    weight : callable
        Share of the variance that is kept, as a function of s = sinc(f T) and the phase pi f S, both (n,).
    weight_words : str
        The weight as a formula.
    has_window : bool
        Whether it needs a window T.
    separations : int
        Number of separations S between its first and its last window; 0 for an index without.
    one_period : bool
        Whether all of its windows lie in one observation period.
    needs_held_body : bool
        Whether it counts a slow drift in full, so that a free rigid body makes it grow without limit.
    """

    name: str
    words: str
    form: Callable[[WindowedError], AnyArray]
    weight: Callable[[FloatArray, FloatArray], FloatArray]
    weight_words: str
    has_window: bool = True
    separations: int = 0
    one_period: bool = True
    needs_held_body: bool = True


def _ones(s: FloatArray, turn: FloatArray) -> FloatArray:
    del turn
    return np.ones_like(s)


def _two_means(s: FloatArray, turn: FloatArray) -> FloatArray:
    return np.asarray(4.0 * np.sin(turn) ** 2 * s**2)


KINDS = {
    kind.name: kind
    for kind in (
        Kind(
            name="APE",
            words="the error",
            form=lambda e: e.instant(),
            weight=_ones,
            weight_words="1",
            has_window=False,
        ),
        Kind(
            name="MPE",
            words="its mean over a window",
            form=lambda e: e.mean(),
            weight=lambda s, _: np.asarray(s**2),
            weight_words="s^2",
        ),
        Kind(
            name="RPE",
            words="the error less that mean",
            form=lambda e: e.instant() - e.mean(),
            weight=lambda s, _: np.asarray(1.0 - s**2),
            weight_words="1 - s^2",
            needs_held_body=False,
        ),
        Kind(
            name="PDE",
            words="difference of two windows' means in one observation period",
            form=lambda e: e.mean(1) - e.mean(),
            weight=_two_means,
            weight_words=r"4 \sin^2(\pi f S) s^2",
            separations=1,
        ),
        Kind(
            name="PRE",
            words="the same in different observation periods",
            form=lambda e: e.mean(1) - e.mean(),
            weight=_two_means,
            weight_words=r"4 \sin^2(\pi f S) s^2",
            separations=1,
            one_period=False,
        ),
    )
}
"""All indices by name. A new index is one row here; no other code distinguishes indices."""


@dataclass(frozen=True)
class Index:
    """Pointing error index with its window and separation.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    window_s : float
        T, s; 0 where it has none.
    separation_s : float
        S from window to window, s; 0 where it has none.

    Raises
    ------
    InputFileError
        The kind is unknown, or a time is missing or not applicable.
    """

    kind: str
    window_s: float = 0.0
    separation_s: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            near = did_you_mean(self.kind.upper(), KINDS) or f"; write one of {', '.join(KINDS)}"
            raise InputFileError(f'index: unknown "{self.kind}"{near}')
        self._check("window_s", "window", self.window_s, needed=self.row.has_window)
        self._check("separation_s", "separation", self.separation_s, needed=self.row.separations > 0)

    def _check(self, key: str, name: str, value: float, *, needed: bool) -> None:
        if not (value > 0.0 if needed else value == 0.0):
            # Zero stands for "not given", so that an index without a window must have exactly 0.
            need = f"needs {key}, above 0" if needed else f"has no {name}"
            raise InputFileError(f"{key}: found {value:.9g}; {self.kind} {need}")

    @property
    def row(self) -> Kind:
        """Definition of its kind."""
        return KINDS[self.kind]

    @property
    def bias_gain(self) -> float:
        """Gain of a constant error; 0 if it does not count."""
        return float(self.gains(np.zeros(1), np.zeros(1))[0, 0].real)

    @property
    def longest_s(self) -> float:
        """Time from the first to the last instant needed, s."""
        return self.window_s + self.row.separations * self.separation_s

    def weight(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the share of the variance that the index keeps at each frequency, (n,); above 1 for differences."""
        return self.row.weight(np.sinc(frequency_hz * self.window_s), np.pi * frequency_hz * self.separation_s)

    def gains(self, frequency_hz: FloatArray, position: FloatArray) -> ComplexArray:
        """Return the gain of a line's phasor, (p, n).

        Parameters
        ----------
        frequency_hz : (n,)
        position : (p,)
            Instants in the window, -1/2 to 1/2 of it.
        """
        gain = self.row.form(_Line(frequency_hz, self.window_s, self.separation_s, position))
        return np.broadcast_to(gain.astype(np.complex128), (position.size, frequency_hz.size))

    def samples(self, sample_rate_hz: float) -> int:
        """Return the number of samples from the first one of the first window to the last one of the last window."""
        window, apart = self._in_samples(sample_rate_hz)
        return window + self.row.separations * apart

    def in_time(self, series: FloatArray, sample_rate_hz: float, start: IntArray, position: FloatArray) -> FloatArray:
        """Return the index of a sampled series, (k, m), by its definition.

        Parameters
        ----------
        series : (M, m)
        sample_rate_hz : float
        start : (k,)
            First sample of each window; `samples` are needed from there on.
        position : (k,)
            Instant in each window, 0 to 1 of it.
        """
        window, apart = self._in_samples(sample_rate_hz)
        return np.asarray(self.row.form(_Series(series, window, apart, start, position)), dtype=np.float64)

    def _in_samples(self, sample_rate_hz: float) -> tuple[int, int]:
        return max(1, round(self.window_s * sample_rate_hz)), round(self.separation_s * sample_rate_hz)


@dataclass(frozen=True, eq=False)
class _Line:
    """Lines of unit phasor at frequencies (n,), evaluated at positions (p,) in a window around time 0."""

    frequency_hz: FloatArray
    window_s: float
    separation_s: float
    position: FloatArray

    def instant(self) -> AnyArray:
        return self._rotation(self.position[:, None] * self.window_s)

    def mean(self, later: int = 0) -> AnyArray:
        return np.asarray(self._rotation(later * self.separation_s) * np.sinc(self.frequency_hz * self.window_s))

    def _rotation(self, time_s: float | FloatArray) -> AnyArray:
        return np.asarray(np.exp(2j * np.pi * self.frequency_hz * time_s))


@dataclass(frozen=True, eq=False)
class _Series:
    """Series (M, m), evaluated in windows of `window` samples that begin at `start` (k,)."""

    series: FloatArray
    window: int
    apart: int
    start: IntArray
    position: FloatArray

    def instant(self) -> AnyArray:
        return np.asarray(self.series[self.start + (self.position * self.window).astype(np.int64)])

    def mean(self, later: int = 0) -> AnyArray:
        first = self.start + later * self.apart
        return np.asarray((self._sums[first + self.window] - self._sums[first]) / self.window)

    @cached_property
    def _sums(self) -> FloatArray:
        # A cumulative sum makes the mean of a window the difference of two entries, whatever its length.
        return np.concatenate([np.zeros((1, self.series.shape[1])), np.cumsum(self.series, axis=0)])
