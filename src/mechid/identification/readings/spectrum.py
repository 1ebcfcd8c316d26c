"""Spectrum of a record: its step rate and stepping, and its distance from a simulated spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.identification.output_error.declaration import DECLARED, Reading, reinterpret_command, reinterpret_target
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.trial import samples_until
from mechid.records.step_rate import SuggestedRate, suggest_rate_without_hum
from mechid.signal.lines import prominence, spectral_lines
from mechid.signal.settings import SERIES
from mechid.signal.spectral_distance import noise_power, power_over_time, spectral_distance


@dataclass(frozen=True, eq=False)
class RecordSpectrum:
    """Spectra of a record's first steps, for comparison with a model, and of the whole record.

    Attributes
    ----------
    target : Target
        The first steps.
    whole : Target
    pieces : int
        Number of pieces into which the first steps are cut, with a spectrum each.
    """

    target: Target
    whole: Target
    pieces: int

    @cached_property
    def bins(self) -> int:
        """Number of compared frequencies."""
        base, size = self.target.base, self.target.samples // self.pieces
        return int(min(RULES.highest_hz, 0.5 * base.sample_rate_hz) * size / base.sample_rate_hz)

    @cached_property
    def power(self) -> FloatArray:
        """Measured power over frequency in each piece, (pieces, F)."""
        return power_over_time(self.target.leading.measured[:], self.pieces)[:, : self.bins]

    @cached_property
    def noise(self) -> float:
        """Noise power at each frequency."""
        return noise_power(self.target.leading.sigma, self.target.samples // self.pieces)

    @cached_property
    def suggested_rate(self) -> SuggestedRate | None:
        """Rate and stepping suggested by the lines of the whole record."""
        fs = self.whole.base.sample_rate_hz
        y = self.whole.leading.measured[: round(self.read_s * fs)]
        found = prominence(y, fs)
        return suggest_rate_without_hum(y, found, spectral_lines(found))

    @property
    def read_s(self) -> float:
        """Length of the record that is read for the suggested rate, s."""
        return min(RULES.own_lines_s if _is_constant(self.command) else RULES.own_ridge_s, self.whole.base.duration_s)

    @cached_property
    def fastest_rate(self) -> float:
        """Largest declared rate within that length, full steps/s."""
        rate = self.command.rate
        inside = [one for time, one in zip(rate.times_s, rate.rates, strict=True) if time < self.read_s]
        return max(map(abs, (*inside, float(np.interp(self.read_s, rate.times_s, rate.rates)))))

    @property
    def command(self) -> Command:
        """Declared command."""
        return self.whole.command

    def read_as(self, taken: Reading) -> Target:
        """Return the first steps under the command of a reading."""
        return self.target if taken == DECLARED else reinterpret_target(self.target, replace(taken, scale=1.0))

    def simulated_power(self, problem: Problem, own: Target, q: FloatArray) -> FloatArray | None:
        """Return the model's power under the command of `own`, or None where the simulation fails."""
        y = problem.model.predict(own, q, own.samples)[0]
        return power_over_time(y, self.pieces)[:, : self.bins] if np.all(np.isfinite(y)) else None

    def distances(self, simulated: FloatArray | None, scales: Sequence[float]) -> list[float]:
        """Return the distance from a simulated power for each scale of the torque; inf where the simulation failed."""
        if simulated is None:
            return [math.inf] * len(scales)
        return [spectral_distance(self.power, simulated / scale**2, self.noise) for scale in scales]

    def low_passed_distances(self, simulated: FloatArray | None, cut_offs_hz: Sequence[float]) -> list[float]:
        """Return the distance for each cut-off frequency, Hz, of a low-pass that filtered the record's signal."""
        if simulated is None:
            return [math.inf] * len(cut_offs_hz)
        size = self.target.samples // self.pieces
        f = (np.arange(simulated.shape[-1]) + SERIES.lowest_bin) * self.target.base.sample_rate_hz / size
        passed = [1.0 / (1.0 + (f / one) ** (2 * RULES.low_pass_order)) for one in cut_offs_hz]
        return [spectral_distance(self.power, simulated * part, self.noise) for part in passed]


def has_readable_spectrum(target: Target) -> bool:
    """Tell whether a record has torque under a command, in enough samples for spectra."""
    enough = target.samples >= RULES.least_samples and target.base.sample_rate_hz >= RULES.least_rate_hz
    driven = target.leading.quantity == "torque" and not isinstance(target.command, MeasuredCommand)
    return enough and driven and samples_until(target, 1.0) < target.samples  # lines come from steps


def spectrum_of(target: Target) -> RecordSpectrum:
    """Return the spectrum of a record, with its own parameters at their declared values."""
    rate, base = target.base.sample_rate_hz, target.base
    rest = max(round((target.time_offset.value - base.start_s) * rate), 0)
    steps = max(samples_until(target, RULES.look_steps), rest + round(RULES.least_look_s * rate))
    samples = min(steps, rest + round(RULES.longest_look_s * rate), target.samples)
    pieces = 1 if _is_constant(target.command) else max(round(samples / rate / RULES.piece_s), 1)
    return RecordSpectrum(target.truncate(samples), target, pieces)


def _is_constant(command: Command) -> bool:
    rates = command.rate.rates
    return all(rate == rates[0] for rate in rates)


def _scale_rate(rate: RateProfile, factor: float) -> RateProfile:
    return RateProfile(rate.times_s, tuple(factor * one for one in rate.rates))


def own_rates(record: RecordSpectrum) -> list[RateProfile]:
    """Return the rates suggested by a record's own lines, where these contradict the declared rate."""
    own, multiples = record.suggested_rate, RULES.rate_multiples
    if own is None or agrees_with_declared_rate(own, record):
        return []
    sign = math.copysign(1.0, max(record.command.rate.rates, key=abs))
    if own.is_constant and own.stepping == "full":
        return [_scale_rate(own.profile, sign)]
    # Microsteps leave only the lines at which the motion repeats: the rate is one of several multiples of them.
    factors = [k * own.repetition_hz / own.rate for k in multiples] if own.is_constant else multiples[:2]
    return [_scale_rate(_extend_to_end(own.profile, record.whole.base.duration_s), sign * factor) for factor in factors]


def _extend_to_end(rate: RateProfile, seconds: float) -> RateProfile:
    """Return a rate extended linearly to the end of a record."""
    if len(rate.rates) == 1:
        return rate
    (_, until), (first, last) = rate.times_s, rate.rates
    return RateProfile.through([(0.0, first), (seconds, first + (last - first) * seconds / until)])


def contradicts_declaration(record: RecordSpectrum) -> bool:
    """Tell whether a record's own lines contradict its declared rate, or its full steps or microsteps."""
    own, coarse = record.suggested_rate, record.command.microsteps <= RULES.coarse_microsteps
    if own is None:
        return False
    return not agrees_with_declared_rate(own, record) or (own.stepping != "" and (own.stepping == "full") != coarse)


def has_lines_of(record: RecordSpectrum, reading: Reading, multiples: Sequence[float]) -> bool:
    """Tell whether a record's full-step lines, if any, are at given multiples of the rate of a reading."""
    own, command = record.suggested_rate, reinterpret_command(record.command, reading)
    if own is None or own.stepping != "full" or command.microsteps > RULES.coarse_microsteps:
        return True
    rate = max(abs(rate) for rate in command.rate.rates) * command.microsteps
    return own.is_constant and _is_near(own.rate / rate, multiples)


def fits_declared_rate_too(record: RecordSpectrum, swapped: Reading) -> bool:
    """Tell whether the lines of a swapped record fit its declared rate as well as the other record's rate."""
    if swapped.rate is None:
        return False
    declared, read = (max(abs(rate) for rate in rate.rates) for rate in (record.command.rate, swapped.rate))
    same = reinterpret_command(record.command, swapped).microsteps == record.command.microsteps
    related = same and _is_near(declared / read, RULES.repeats)
    return related and not has_lines_of(record, swapped, RULES.full_step_lines[:1])


def agrees_with_declared_rate(own: SuggestedRate, record: RecordSpectrum) -> bool:
    """Tell whether the lines of a record may come from the declared rate."""
    command, declared = record.command, record.fastest_rate
    if own.is_constant != _is_constant(command):
        return False
    if command.microsteps == 1 and own.stepping == "full":
        return _is_near(own.rate / declared, RULES.full_step_lines)
    repeats = declared / (own.repetition_hz if own.is_constant else own.rate)
    return _is_near(repeats, RULES.repeats, RULES.same_rate if own.is_constant else RULES.same_end_rate)


def _is_near(ratio: float, multiples: Sequence[float], within: float = RULES.same_rate) -> bool:
    return any(abs(ratio / one - 1.0) < within for one in multiples)
