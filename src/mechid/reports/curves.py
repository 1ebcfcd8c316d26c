"""Curves in the figures of a record: its trace, spectra, whiteness, and the spectrogram of a sweep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.analysis.commanded_rate import commanded_rate
from mechid.analysis.prediction import Prediction, predict
from mechid.analysis.validation import ChannelValidation, RecordValidation
from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.record_result import ChannelFit
from mechid.ink.extremes import reduce_to_extremes
from mechid.ink.quantities import channel_key
from mechid.reports.outline import Outline, outline_of
from mechid.reports.trace import Trace, trace_of
from mechid.signal import autocorrelation, peak_spectrum
from mechid.signal.series import Series, blocks, mean_of, stretch_of
from mechid.signal.spectrogram import WINDOWS, spectrogram, usual_window_s
from mechid.signal.stored_series import is_long
from mechid.simulation.simulator import TimeBase

GROUPS = 3000
"""Groups of a spectrum, equally wide on a logarithmic axis; up to about 400 Hz, a record of 1 s keeps every bin."""
LAGS = 100
START_S = 0.3
"""Length of the separately drawn start of a record, s."""
WORST = "least followed"
"""Name of the stretch of a long record with the largest misfit."""
HIGHEST_BINS = 500
"""Largest number of bins of a spectrogram."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectrogram:
    """Amplitudes in N m, (F, C) each, of record and prediction at frequencies (F,) Hz and record times (C,) s."""

    time_s: FloatArray
    frequency_hz: FloatArray
    measured: FloatArray
    modelled: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Lines:
    """Lines of a stretch of a record on paper: record times in s and samples, (2, M) each."""

    measured: FloatArray
    modelled: FloatArray
    residual: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Curves:
    """The curves of one channel of a record.

    Attributes
    ----------
    name : str
        Name of the record, with the quantity unless this is its leading channel.
    record, quantity : str
    base : TimeBase
    whole, start : Lines
        Measurement less offset and drift, prediction, and residual, for figures on paper.
    largest_s : float
        Record time of the measured sample furthest from the mean.
    trace : Trace or Outline
        All samples, for the page; for a long record, its outline and all samples of some stretches.
    spectrum_hz, measured, modelled, residual : (M,)
        Amplitude spectra over the record, N m, the peak of each group of bins; offset and drift removed.
    density_hz, residual_density : (D,)
        Root of Welch's density of the residual, N m/sqrt(Hz).
    noise_density : float
        Root density of white noise at the record's noise floor.
    correlation : (L,)
        Autocorrelation of the residual from lag 1.
    limit : float
        Magnitude below which 95 % of the autocorrelations of a white series lie.
    rate : (R, 2)
        Record time in s and full steps/s, linear between; one row is a constant rate.
    spectrogram : Spectrogram or None
        None for a constant rate.
    """

    name: str
    record: str
    quantity: str
    base: TimeBase
    whole: Lines
    start: Lines
    largest_s: float
    trace: Trace | Outline
    spectrum_hz: FloatArray
    measured: FloatArray
    modelled: FloatArray
    residual: FloatArray
    density_hz: FloatArray
    residual_density: FloatArray
    noise_density: float
    correlation: FloatArray
    limit: float
    rate: FloatArray
    spectrogram: Spectrogram | None

    @property
    def trace_name(self) -> str:
        """Name of the figure of its samples."""
        return f"{self.name}_{self.quantity}" if self.name == self.record else self.name

    @property
    def largest_rate(self) -> float:
        """Largest magnitude of the rate over the record, full steps/s."""
        return float(np.abs(self.rate[:, 1]).max())


def record_curves(
    campaign: Campaign, fit: Fit, validation: RecordValidation, predictions: Mapping[str, Prediction] | None = None
) -> list[Curves]:
    """Return the curves of each channel of a record, predicted if not given; NaN after a failed simulation."""
    record, leading = campaign.record(validation.name), next(iter(validation.channels))
    predictions = predictions or predict(record, fit)
    return [
        _curves(record, fit, channel_key(record.name, quantity, leading), channel, predictions[quantity])
        for quantity, channel in validation.channels.items()
    ]


def _curves(record: CampaignRecord, fit: Fit, name: str, channel: ChannelValidation, p: Prediction) -> Curves:
    noise = fit.records[record.name].known_noise_of(channel.quantity)
    rate_hz = p.base.sample_rate_hz
    # Two samples at least, since one draws no line.
    start = min(max(round(START_S * rate_hz) + 1, 2), p.base.samples)
    rate = rate_over(record_as_fitted(record, fit), p.base)
    # Samples are NaN where the simulation failed; the curves carry them on without warnings.
    with np.errstate(all="ignore"):
        frequency, measured = peak_spectrum(p.level, rate_hz, GROUPS)
        return Curves(
            name=name,
            record=record.name,
            quantity=channel.quantity,
            base=p.base,
            whole=_lines(p, p.base.samples),
            start=_lines(p, start),
            largest_s=p.base.start_s + _largest(p.measured) / rate_hz,
            trace=_trace(p, noise, fit.records[record.name].channels[channel.quantity]),
            spectrum_hz=frequency,
            measured=measured,
            modelled=peak_spectrum(p.modelled, rate_hz, GROUPS)[1],
            residual=peak_spectrum(p.residual, rate_hz, GROUPS)[1],
            # The axes are logarithmic, and 0 Hz has no place on them.
            density_hz=channel.spectrum_hz[1:],
            residual_density=np.sqrt(channel.residual_density[1:]),
            # White noise has a constant one-sided density up to half the sample rate.
            noise_density=noise * math.sqrt(2.0 / rate_hz),
            # Lag 0 is left out: it is 1 by definition.
            correlation=autocorrelation(p.residual, LAGS)[1:],
            # Autocorrelations of N white samples scatter by 1/sqrt(N) about zero.
            limit=1.96 / math.sqrt(p.measured.size),
            rate=rate,
            # At a constant rate the lines do not move, and the spectrum shows them all.
            spectrogram=_spectrogram(p) if len(rate) > 1 else None,
        )


def _trace(p: Prediction, noise: float, fitted: ChannelFit) -> Trace | Outline:
    """Return the samples of a record for the page, or its outline if the record is long."""
    if not is_long(p.base.samples):
        return trace_of(p, noise)
    largest_s = p.base.start_s + _largest(p.measured) / p.base.sample_rate_hz
    return outline_of(p, noise, {"start": p.base.start_s, "largest": largest_s, WORST: fitted.worst_at_s})


def rate_over(record: CampaignRecord, base: TimeBase) -> FloatArray:
    """Return the commanded rate over a record's time, (R, 2) of s and full steps/s; (1, 2) where it is constant."""
    return commanded_rate(record.command.rate, record.time_offset.value, base)


def _lines(p: Prediction, samples: int) -> Lines:
    """Return the lines of the first samples."""
    series = (p.level, p.modelled, p.residual)
    measured, modelled, residual = (reduce_to_extremes(stretch_of(y, 0, samples), p.base) for y in series)
    return Lines(measured=measured, modelled=modelled, residual=residual)


def _largest(y: Series) -> int:
    """Return the sample furthest from the mean."""
    mean = mean_of(y)
    furthest = [int(part.start + np.argmax(np.abs(y[part] - mean))) for part in blocks(y.size)]
    return max(furthest, key=lambda k: float(abs(y[k : k + 1][0] - mean)))


def _spectrogram(p: Prediction) -> Spectrogram:
    window = usual_window_s(p.measured.size / p.base.sample_rate_hz)
    time, frequency, measured = spectrogram(p.level, p.base.sample_rate_hz, window, WINDOWS)
    modelled = spectrogram(p.modelled, p.base.sample_rate_hz, window, WINDOWS)[2]
    kept = slice(0, HIGHEST_BINS)
    return Spectrogram(
        time_s=time + p.base.start_s, frequency_hz=frequency[kept], measured=measured[kept], modelled=modelled[kept]
    )
