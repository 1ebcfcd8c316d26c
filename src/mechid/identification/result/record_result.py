"""Result of one record: the fit of its channels, and parameters of a held-out record fitted on its first part."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Self

from mechid.identification.output_error.declaration import DECLARED, Reading
from mechid.identification.result.missing_effects import EffectValue
from mechid.signal.runs import Runs
from mechid.units import unit_words


@dataclass(frozen=True, kw_only=True)
class MaskedMoment:
    """A moment that the search left out of a record: the model follows the record before and after it.

    Attributes
    ----------
    first, stop : int
        First and last-plus-one sample.
    from_s, to_s : float
        Record time of these samples.
    largest : float
        Largest magnitude of the residual there, in the channel's SI unit.
    over_noise : float
        Ratio of `largest` to the noise level.
    chi_square : float
        Increase of the sum of squares if the moment counted, beyond the share of noise.
    """

    first: int
    stop: int
    from_s: float
    to_s: float
    largest: float
    over_noise: float
    chi_square: float

    def describe(self, unit: str) -> str:
        """Describe the time and the residual of the moment, as a clause."""
        return (
            f"{self.from_s:.6g} to {self.to_s:.6g} s, residual up to {self.largest:.3g} {unit}, {self.over_noise:.3g} "
            f"times the noise; if counted, it would add {self.chi_square:.3g} to the sum of squares"
        )


@dataclass(frozen=True, kw_only=True)
class ChannelFit:
    """Fit of one channel of a record, in the SI unit `unit`.

    Attributes
    ----------
    use : {"estimate", "validate"}
        Whether it was fitted, or only compared.
    fit_percent : float
        100 (1 - ||residual|| / ||measured - mean||), offset and drift removed from both.
    residual_rms, noise_sigma : float
        The noise is that of the channel itself: declared, or from quiet stretches, its high-frequency floor, its
        resolution; where growth stalled at that level, the residual's RMS.
    offset, drift : float or None
        At the first sample, and per second: measured = model + offset + drift t. None where not removed.
    quantisation : float
        Declared resolution, 0 where none is declared.
    prefilter_order : int
        Order of the autoregressive model that whitened the residual; 0 without one.
    rejected : int
        Rejected samples among those used.
    rejected_runs : tuple of (int, int)
        All rejected samples, bridged gaps, spikes and masked moments: first and last-plus-one of each run.
    masked : tuple of MaskedMoment
        Moments that the search left out.
    noise_rests_on : str
        Words of the `NoiseSource`; empty in files of earlier versions.
    noise_known : float or None
        Noise level before the fit; equals `noise_sigma` unless that rests on the residual. None in files of earlier
        versions.
    followed_percent : float
        Share of the used samples in windows of 50 ms that the model follows (`signal.following`), without masked ones.
    lost_at_s : float or None
        Record time at which the first window begins that the model does not follow; None where it follows all.
    worst_at_s, worst : float
        Record time of the largest ratio of the residual to its limit, and that ratio.
    out_of_step_at_s : float or None
        Record time at which an angle has departed from the model by two full steps; None where it has not.
    lines : tuple of (float, float, float)
        Removed lines, such as mains hum: Hz, amplitude, phase in rad of the cosine at the first sample.
    """

    unit: str
    use: str
    fit_percent: float
    residual_rms: float
    noise_sigma: float
    offset: float | None
    drift: float | None
    quantisation: float = 0.0
    prefilter_order: int = 0
    rejected: int = 0
    rejected_runs: Runs = ()
    masked: tuple[MaskedMoment, ...] = ()
    noise_rests_on: str = ""
    noise_known: float | None = None
    followed_percent: float = 100.0
    lost_at_s: float | None = None
    worst_at_s: float = 0.0
    worst: float = 0.0
    out_of_step_at_s: float | None = None
    lines: tuple[tuple[float, float, float], ...] = ()

    @property
    def initial_noise(self) -> float:
        """Noise level before the fit."""
        return self.noise_sigma if self.noise_known is None else self.noise_known

    @property
    def residual_over_noise(self) -> float:
        """Ratio of the residual's RMS to the noise level: the initial one, or a raised one above it."""
        level = max(self.initial_noise, self.noise_sigma)
        return self.residual_rms / level if level > 0.0 else math.inf

    @property
    def is_followed(self) -> bool:
        """Whether the model follows the channel to its end."""
        return self.lost_at_s is None and self.out_of_step_at_s is None


@dataclass(frozen=True, kw_only=True)
class Nuisance:
    """Parameters of a held-out record that were fitted on its first part; the rest judges the fit.

    Attributes
    ----------
    samples : int
        Number of samples of the first part.
    until_s : float
        Record time at which the first part ends and the judged part begins.
    parameters : mapping of dotted name to EffectValue
        Values, in the file's units, with their standard errors; no error where the first part does not determine it.
    """

    samples: int
    until_s: float
    parameters: Mapping[str, EffectValue]

    @property
    def values(self) -> dict[str, float]:
        """The values by dotted name."""
        return {name: own.value for name, own in self.parameters.items()}

    def words(self) -> Iterator[str]:
        """Yield each value with its error, under its name in the record's table."""
        for name, own in self.parameters.items():
            error = "" if own.std_error is None else f" +- {own.std_error:.2g}"
            yield f"{name.split('.', 2)[2]} = {own.value:.6g}{error} {own.unit}".rstrip()

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of estimate.json."""
        return {
            "samples": self.samples,
            "until_s": self.until_s,
            "parameters": {name: asdict(own) for name, own in self.parameters.items()},
        }

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Read an entry of estimate.json."""
        own = {name: EffectValue(**value) for name, value in entry["parameters"].items()}
        return cls(samples=int(entry["samples"]), until_s=float(entry["until_s"]), parameters=own)


@dataclass(frozen=True, kw_only=True)
class RecordFit:
    """Fit of one record; with several channels, the figures are those of the leading one, the torque if measured.

    Attributes
    ----------
    fit_percent : float
        100 (1 - ||residual|| / ||measured - mean||), offset and drift removed from both.
    residual_rms, noise_sigma : float
        In the channel's SI unit. The noise is that of the record itself, as in `ChannelFit`.
    offset, drift : float or None
        At the first sample, and per second: measured = model + offset + drift t. None where not removed.
    samples : int
        Samples used.
    horizon_s : float
        Time from the first sample over which noise explains the residual, s; a small model error ends it early.
    prefilter_order : int
        Order of the autoregressive model that whitened the residual; 0 without one.
    rejected : int
        Rejected samples.
    channels : mapping of quantity to ChannelFit
        All channels, the leading one first.
    reading : Reading
        Reinterpretation of the record, where the fit read it otherwise than the campaign file declares.
    nuisance : Nuisance or None
        For a held-out record, the fit of its first part; its other figures then refer to the rest.
    followed_of_whole : float or None
        Percent of the whole record that the model follows, as `followed_percent`; None: that of the samples used.
    validation : mapping or None
        The table of that name in estimate.json, for a fit that was read; `mechid.analysis.fit_residuals` reads it.
    """

    name: str
    use: str
    samples: int
    fit_percent: float
    residual_rms: float
    noise_sigma: float
    offset: float | None
    drift: float | None
    horizon_s: float
    prefilter_order: int = 0
    rejected: int = 0
    channels: Mapping[str, ChannelFit] = field(default_factory=dict)
    reading: Reading = DECLARED
    nuisance: Nuisance | None = None
    followed_of_whole: float | None = None
    validation: Mapping[str, Any] | None = field(default=None, compare=False, repr=False)

    @property
    def followed_percent(self) -> float:
        """Percent of the whole record in windows that the model follows, for the channel that it follows least."""
        if self.followed_of_whole is not None:
            return self.followed_of_whole
        # Files of earlier versions lack the share of the whole record.
        return min((c.followed_percent for c in self.channels.values()), default=100.0)

    @property
    def residual_over_noise(self) -> float:
        """Ratio of the leading channel's residual RMS to its noise level before the fit."""
        return self.residual_rms / self.noise_known if self.noise_known > 0.0 else math.inf

    @property
    def masked(self) -> tuple[MaskedMoment, ...]:
        """Moments that the search left out, from the channel in which their sum of squares is largest."""
        own = (c.masked for c in self.channels.values() if c.masked)
        return max(own, key=lambda moments: sum(m.chi_square for m in moments), default=())

    def describe_masked(self) -> str:
        """Describe the moments that the search left out, as a clause; empty where there are none."""
        if not self.masked:
            return ""
        unit = unit_words(next(quantity for quantity, c in self.channels.items() if c.masked is self.masked))
        count = "one moment was" if len(self.masked) == 1 else f"{len(self.masked)} moments were"
        moments = "; ".join(moment.describe(unit) for moment in self.masked)
        return (
            f"{count} left out that the model does not follow, though it follows the record before and after: {moments}"
        )

    @property
    def lines(self) -> tuple[float, ...]:
        """Frequency in Hz of each line that was removed from the leading channel."""
        channel = next(iter(self.channels.values()), None)
        return tuple(hz for hz, _, _ in channel.lines) if channel else ()

    def residual_of(self, quantity: str) -> float:
        """Return the residual's RMS of a channel, in its SI unit."""
        own = self.channels.get(quantity)
        return own.residual_rms if own else self.residual_rms

    @property
    def noise_rests_on(self) -> str:
        """Source of the leading channel's noise level, empty where it is not known."""
        return next((c.noise_rests_on for c in self.channels.values()), "")

    @property
    def noise_known(self) -> float:
        """Noise level of the leading channel before the fit."""
        return next((c.initial_noise for c in self.channels.values()), self.noise_sigma)

    def known_noise_of(self, quantity: str) -> float:
        """Return the noise level of a channel before the fit, in its SI unit."""
        own = self.channels.get(quantity)
        return own.initial_noise if own else self.noise_sigma

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        return {
            "use": self.use,
            "samples": self.samples,
            "fit_percent": self.fit_percent,
            "residual_rms": self.residual_rms,
            "noise_sigma": self.noise_sigma,
            "offset": self.offset,
            "drift": self.drift,
            "horizon_s": self.horizon_s,
            "prefilter_order": self.prefilter_order,
            "rejected": self.rejected,
            "masked": [asdict(moment) for moment in self.masked],
            "noise_rests_on": self.noise_rests_on,
            "noise_known": self.noise_known,
            "followed_percent": self.followed_percent,
            "residual_over_noise": self.residual_over_noise,
            "channels": {quantity: asdict(c) for quantity, c in self.channels.items()},
            "taken": self.reading.to_dict(),
            "nuisance": self.nuisance.to_dict() if self.nuisance else None,
        }


def masks_of(records: Mapping[str, RecordFit]) -> dict[str, Runs]:
    """Return the runs of samples that a search left out of records, by name."""
    return {name: tuple((m.first, m.stop) for m in r.masked) for name, r in records.items() if r.masked}
