"""Data of a diagnosis' figures: where each effect acts, spectra of the residual, its worst stretch.

The share of an effect is the output of the model with all effects less that of the model without this one, each fitted:
what no other parameter can imitate. Both are models, so that it holds no noise. As elsewhere in reports a residual is
measured less model, offset and drift removed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.search import Found
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
        Of the mechanism as written, and of the model with all effects.
    shares : mapping of str to (M,)
        Of each effect's share, by its name.
    noise : float
        That of white noise as large as the channel's.
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
    """A channel over the stretch where the mechanism as written misses it most, (n,) each in the channel's unit.

    Attributes
    ----------
    record, quantity : str
    start_s, sample_rate_hz : float
        Record time of the first sample.
    measured : (n,)
        Less offset and drift.
    before, after : (n,)
        The model's: the mechanism as written, and with all effects.
    """

    record: str
    quantity: str
    start_s: float
    sample_rate_hz: float
    measured: FloatArray
    before: FloatArray
    after: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Pictures:
    """What is drawn of a diagnosis.

    Attributes
    ----------
    acts : mapping of str to mapping of str to Strongest
        Where in frequency the share of each effect is strongest, in each record, by the effect's name and the record's.
    spectra : tuple of ResidualSpectra
        Of the records that the mechanism as written misses most, the worst first.
    stretch : Stretch or None
        None where nothing can be drawn.
    """

    acts: Mapping[str, Mapping[str, StrongestParts]]
    spectra: tuple[ResidualSpectra, ...]
    stretch: Stretch | None


NONE = Pictures(acts={}, spectra=(), stretch=None)


@dataclass(frozen=True, eq=False)
class _Channel:
    """A channel less offset and drift, what of it is left before and after, and the effects' shares, (N,) each."""

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
    def missed(self) -> float:
        """RMS of what the mechanism as written leaves over that of the noise."""
        return _rms(self.before) / self.noise


def pictures_of(found: Found, called: Mapping[str, str]) -> Pictures:
    """Return what is drawn of where a search has ended; nothing where there was nothing to explain.

    Parameters
    ----------
    found : Found
    called : mapping of str to str
        What each of its effects is called; those of which no share is wanted are left out.
    """
    if not found.model.effects and found.before.over_noise <= NOISE.misfit:
        return NONE
    targets = [t for t in found.model.problem.targets if t.name in found.model.setting.windows]
    done = in_threads(lambda target: list(_channels(found, target, called)), targets, found.model.problem.workers)
    channels = [channel for each in done for channel in each]
    worst = sorted(_largest(channels, lambda one: one.missed), key=lambda one: -one.missed)
    return Pictures(
        acts={name: _acts(name, channels) for name in called.values()},
        spectra=tuple(map(_spectra, worst[: DIAGNOSIS.records_drawn])),
        stretch=_stretch(worst[0]) if worst else None,
    )


def _rms(series: FloatArray) -> float:
    return float(np.sqrt(np.mean(series**2)))


def _largest(channels: Iterable[_Channel], size: Callable[[_Channel], float]) -> list[_Channel]:
    """Return that channel of each record in which something is largest."""
    return list({one.record: one for one in sorted(channels, key=size)}.values())


def _channels(found: Found, target: Target, called: Mapping[str, str]) -> Iterator[_Channel]:
    """Yield the channels of a record, those alone that every model follows to the record's end."""
    before, after = _remainders(found.before, target.name), _remainders(found.model, target.name)
    less = {name: _remainders(found.less[effect], target.name) for effect, name in called.items()}
    for k, (was, left) in enumerate(zip(before, after, strict=True)):
        own = {name: series[k] for name, series in less.items()}
        if all(is_finite(each.series) for each in (was, left, *own.values())):
            level = Remainder(target.channels[k].measured, left.line)[:]
            shares = {name: each[:] - left[:] for name, each in own.items()}
            yield _Channel(target, k, level, was[:], left[:], shares)


def _remainders(model: Model, record: str) -> list[Remainder]:
    """Return what a model leaves of each channel of a record, offset, drift and lines removed."""
    target = next(t for t in model.problem.targets if t.name == record)
    series = misfit_series(model.problem.model, target, model.q, model.setting.windows[record])
    return [_remainder(channel, -r[:]) for channel, r in zip(target.channels, series, strict=True)]


def _remainder(channel: TargetChannel, left: FloatArray) -> Remainder:
    line = channel.line(left, channel.rejected) if is_finite(left) else Line()
    return Remainder(left, line, rejected=channel.rejected)


def _acts(name: str, channels: Iterable[_Channel]) -> dict[str, StrongestParts]:
    """Return where the share of an effect is strongest in each record, of the channel that has most of it."""
    leading = _largest(channels, lambda one: one.share_over_noise(name))
    return {one.record: find_strongest(one.shares[name], one.rate_hz) for one in leading}


def _spectra(one: _Channel) -> ResidualSpectra:
    def grouped(series: FloatArray) -> tuple[FloatArray, FloatArray]:
        return average_in_groups(*power_density(series, one.rate_hz), DIAGNOSIS.groups)

    def root(series: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(grouped(series)[1]))

    return ResidualSpectra(
        record=one.record,
        quantity=one.quantity,
        frequency_hz=grouped(one.before)[0],
        before=root(one.before),
        after=root(one.after),
        shares={name: root(series) for name, series in one.shares.items()},
        noise=one.noise * math.sqrt(2.0 / one.rate_hz),
    )


def _stretch(one: _Channel) -> Stretch:
    """Return the stretch of which the mechanism as written leaves most."""
    size = min(max(round(_length_s(one) * one.rate_hz), 2), one.before.size)
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
    """Return some periods of the strongest line or band of what is left, within limits, s."""
    found = find_strongest(one.before, one.rate_hz).frequencies_hz
    return (
        min(max(DIAGNOSIS.periods / found[0], DIAGNOSIS.shortest_s), DIAGNOSIS.longest_s)
        if found
        else DIAGNOSIS.longest_s
    )
