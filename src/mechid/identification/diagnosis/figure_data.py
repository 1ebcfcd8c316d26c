"""Data of a diagnosis' figures: frequencies of each effect, spectra of the residual, its worst stretch.

The share of an effect is the output of the model with all effects minus that of the model without this one, each
fitted. It is the part that no other parameter can imitate. Both are simulated, so the share contains no noise. As
elsewhere in reports, a residual is measured minus model, with offset and drift removed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.search import SearchResult
from mechid.identification.diagnosis.settings import DIAGNOSIS
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.density import average_in_groups, power_density
from mechid.signal.remainder import Remainder
from mechid.signal.series import is_finite
from mechid.signal.strongest import StrongestParts, find_strongest
from mechid.signal.trend import Line


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualSpectra:
    """Roots of Welch's densities of one channel's residuals, (M,) each in the channel's unit/sqrt(Hz).

    Attributes
    ----------
    record, quantity : str
    frequency_hz : (M,)
        Groups of bins, about equally wide on a logarithmic axis.
    before, after : (M,)
        Residual of the mechanism as written, and of the model with all effects.
    shares : mapping of str to (M,)
        Share of each effect, by its name.
    noise : float
        Root of the density of white noise at the channel's noise level.
    """

    record: str
    quantity: str
    frequency_hz: FloatArray
    before: FloatArray
    after: FloatArray
    shares: Mapping[str, FloatArray]
    noise: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """A channel over the stretch with the largest residual of the mechanism as written, (n,) in the channel's unit.

    Attributes
    ----------
    record, quantity : str
    start_s, sample_rate_hz : float
        Record time of the first sample.
    measured : (n,)
        Measured values, offset and drift removed.
    before, after : (n,)
        Simulated by the mechanism as written, and by the model with all effects.
    """

    record: str
    quantity: str
    start_s: float
    sample_rate_hz: float
    measured: FloatArray
    before: FloatArray
    after: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class FigureData:
    """Data of the figures of a diagnosis.

    Attributes
    ----------
    acts : mapping of str to mapping of str to Strongest
        Frequencies at which the share of each effect is strongest, by the names of the effect and of the record.
    spectra : tuple of ResidualSpectra
        Spectra of the records with the largest residuals of the mechanism as written, the worst first.
    stretch : Stretch or None
        None where no channel can be drawn.
    """

    acts: Mapping[str, Mapping[str, StrongestParts]]
    spectra: tuple[ResidualSpectra, ...]
    stretch: Stretch | None


NO_PICTURES = FigureData(acts={}, spectra=(), stretch=None)


@dataclass(frozen=True, eq=False)
class _Channel:
    """A channel without offset and drift, its residuals before and after, and the effects' shares, (N,) each."""

    target: Target
    number: int
    level: FloatArray
    before: FloatArray
    after: FloatArray
    shares: Mapping[str, FloatArray]

    @property
    def record(self) -> str:
        return self.target.name

    @property
    def quantity(self) -> str:
        return self.target.quantities[self.number]

    @property
    def rate_hz(self) -> float:
        return self.target.base.sample_rate_hz

    @property
    def noise(self) -> float:
        return self.target.channels[self.number].sigma

    def share_over_noise(self, name: str) -> float:
        return _rms(self.shares[name]) / self.noise

    @property
    def noise_ratio(self) -> float:
        """Residual-to-noise ratio of the mechanism as written."""
        return _rms(self.before) / self.noise


def compute_figure_data(found: SearchResult, called: Mapping[str, str]) -> FigureData:
    """Compute the data of the figures at the end of a search; empty where there was nothing to explain.

    Parameters
    ----------
    found : SearchResult
    called : mapping of str to str
        Displayed name of each effect; effects without an entry get no share.
    """
    if not found.model.effects and found.before.over_noise <= NOISE.misfit:
        return NO_PICTURES
    targets = [t for t in found.model.problem.targets if t.name in found.model.setting.windows]
    done = in_threads(lambda target: list(_channels(found, target, called)), targets, found.model.problem.workers)
    channels = [channel for each in done for channel in each]
    worst = sorted(_largest(channels, lambda one: one.noise_ratio), key=lambda one: -one.noise_ratio)
    return FigureData(
        acts={name: _strongest_frequencies(name, channels) for name in called.values()},
        spectra=tuple(map(_residual_spectra, worst[: DIAGNOSIS.records_drawn])),
        stretch=_worst_stretch(worst[0]) if worst else None,
    )


def _rms(series: FloatArray) -> float:
    return float(np.sqrt(np.mean(series**2)))


def _largest(channels: Iterable[_Channel], size: Callable[[_Channel], float]) -> list[_Channel]:
    """Return the channel of each record with the largest `size`."""
    # Later entries replace earlier ones, so the largest channel of a record remains.
    return list({one.record: one for one in sorted(channels, key=size)}.values())


def _channels(found: SearchResult, target: Target, called: Mapping[str, str]) -> Iterator[_Channel]:
    """Yield the channels of a record that every model simulates to the record's end."""
    before, after = _remainders(found.before, target.name), _remainders(found.model, target.name)
    less = {name: _remainders(found.less[effect], target.name) for effect, name in called.items()}
    for k, (was, left) in enumerate(zip(before, after, strict=True)):
        own = {name: series[k] for name, series in less.items()}
        if all(is_finite(each.series) for each in (was, left, *own.values())):
            level = Remainder(target.channels[k].measured, left.line)[:]
            shares = {name: each[:] - left[:] for name, each in own.items()}
            yield _Channel(target, k, level, was[:], left[:], shares)


def _remainders(model: CandidateModel, record: str) -> list[Remainder]:
    """Return a model's residual of each channel of a record, with offset, drift and lines removed."""
    target = next(t for t in model.problem.targets if t.name == record)
    series = misfit_series(model.problem.model, target, model.q, model.setting.windows[record])
    return [_remainder(channel, -r[:]) for channel, r in zip(target.channels, series, strict=True)]


def _remainder(channel: TargetChannel, left: FloatArray) -> Remainder:
    line = channel.line(left, channel.rejected) if is_finite(left) else Line()
    return Remainder(left, line, rejected=channel.rejected)


def _strongest_frequencies(name: str, channels: Iterable[_Channel]) -> dict[str, StrongestParts]:
    """Return the strongest frequencies of an effect in each record, from the channel with the largest share."""
    leading = _largest(channels, lambda one: one.share_over_noise(name))
    return {one.record: find_strongest(one.shares[name], one.rate_hz) for one in leading}


def _residual_spectra(one: _Channel) -> ResidualSpectra:
    def group_density(series: FloatArray) -> tuple[FloatArray, FloatArray]:
        return average_in_groups(*power_density(series, one.rate_hz), DIAGNOSIS.groups)

    def root(series: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(group_density(series)[1]))

    return ResidualSpectra(
        record=one.record,
        quantity=one.quantity,
        frequency_hz=group_density(one.before)[0],
        before=root(one.before),
        after=root(one.after),
        shares={name: root(series) for name, series in one.shares.items()},
        # One-sided density of white noise: 2 sigma^2 over the sample rate.
        noise=one.noise * math.sqrt(2.0 / one.rate_hz),
    )


def _worst_stretch(one: _Channel) -> Stretch:
    """Return the stretch in which the residual of the mechanism as written is largest."""
    size = min(max(round(_length_s(one) * one.rate_hz), 2), one.before.size)
    # Cumulative power: the power of every window is one difference.
    power = np.concatenate([[0.0], np.cumsum(one.before**2)])
    first = int(np.argmax(power[size:] - power[:-size]))
    part = slice(first, first + size)
    return Stretch(
        record=one.record,
        quantity=one.quantity,
        start_s=one.target.base.start_s + first / one.rate_hz,
        sample_rate_hz=one.rate_hz,
        measured=one.level[part],
        before=one.level[part] - one.before[part],
        after=one.level[part] - one.after[part],
    )


def _length_s(one: _Channel) -> float:
    """Return some periods of the strongest line or band of the residual, within limits, s."""
    found = find_strongest(one.before, one.rate_hz).frequencies_hz
    return (
        min(max(DIAGNOSIS.periods / found[0], DIAGNOSIS.shortest_s), DIAGNOSIS.longest_s)
        if found
        else DIAGNOSIS.longest_s
    )
