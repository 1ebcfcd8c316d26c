"""A record by its spectrum: what it shows of its stepping, and how far a run of the model is from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.identification.contradiction.alternatives import samples_of
from mechid.identification.output_error.declaration import DECLARED, Reading, command_as_read, target_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.records.step_rate import SuggestedRate, suggested_beside_hum
from mechid.signal.likeness import noise_power, power_over_time, spectral_distance
from mechid.signal.lines import prominence, spectral_lines
from mechid.signal.settings import SERIES

COARSE = 2
"""Steps a full step, at most, that fill a spectrum; a choice, not measured."""
STEPS, LEAST_S, MOST_S, PIECE_S = 8.0, 0.25, 2.0, 0.5
"""Full steps of a record that are run, within these times; of a rate that varies in pieces, as its lines move. It
keeps a look at a campaign at 0.3 s (docs/identification.md); not varied otherwise."""
HIGHEST_HZ = 1000.0
"""Of the spectra that are compared. A choice, not measured."""
ORDER = 4
"""Of the low-pass that a record may have passed; |H|^2 = 1/(1 + (f/f_c)^(2 n)); a choice, not measured."""
OWN_LINES_S, OWN_RIDGE_S = 4.0, 8.0
"""How much of a record is looked at for its own step rate, by its lines and over time; a choice, not measured."""
SAME_RATE, SAME_END = 0.01, 0.1
"""Of a rate, and of a swept rate's end: what is off by no more is no other one; a choice, not measured."""
REPEATS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Full steps at the rate declared after which a record may repeat itself. A motor may repeat itself after two or
four steps, or twice in a step."""
FULL_STEPS = (1.0, 2.0)
"""Times the rate declared that the lines of full steps may suggest."""
SLOWEST_HZ, FEWEST_SAMPLES = 64.0, 32
"""Sample rate and samples from which a record's spectra tell anything; a choice, not measured."""
PARTS = (1.0, 2.0, 4.0)
"""Times what its lines are multiples of that a step rate may be; of a ridge over time, the first two."""


@dataclass(frozen=True, eq=False)
class RecordSight:
    """A record's first steps, and all of it.

    Attributes
    ----------
    target : Target
        Its first steps.
    whole : Target
    pieces : int
        Into which these steps are cut for their spectra.
    """

    target: Target
    whole: Target
    pieces: int

    @cached_property
    def bins(self) -> int:
        """Frequencies that are compared."""
        base, size = self.target.base, self.target.samples // self.pieces
        return int(min(HIGHEST_HZ, 0.5 * base.sample_rate_hz) * size / base.sample_rate_hz)

    @cached_property
    def power(self) -> FloatArray:
        """Measured power over frequency in each piece, (pieces, F)."""
        return power_over_time(self.target.leading.measured[:], self.pieces)[:, : self.bins]

    @cached_property
    def noise(self) -> float:
        """Power of the noise at each frequency."""
        return noise_power(self.target.leading.sigma, self.target.samples // self.pieces)

    @cached_property
    def own(self) -> SuggestedRate | None:
        """How the record seems to be driven by its own lines."""
        fs = self.whole.base.sample_rate_hz
        y = self.whole.leading.measured[: round(self.own_s * fs)]
        found = prominence(y, fs)
        return suggested_beside_hum(y, found, spectral_lines(found))

    @property
    def own_s(self) -> float:
        """How much of it is looked at for that, s."""
        return min(OWN_LINES_S if _is_constant(self.command) else OWN_RIDGE_S, self.whole.base.duration_s)

    @cached_property
    def fastest(self) -> float:
        """The largest rate that is declared within that, full steps/s."""
        rate = self.command.rate
        inside = [one for time, one in zip(rate.times_s, rate.rates, strict=True) if time < self.own_s]
        return max(map(abs, (*inside, float(np.interp(self.own_s, rate.times_s, rate.rates)))))

    @property
    def command(self) -> Command:
        """As declared."""
        return self.whole.command

    def read_as(self, taken: Reading) -> Target:
        """Return what is looked at under another command."""
        return self.target if taken == DECLARED else target_as_read(self.target, replace(taken, scale=1.0))

    def modelled(self, problem: Problem, own: Target, q: FloatArray) -> FloatArray | None:
        """Return the model's power under the command of a target, or None where it cannot be run."""
        y = problem.model.predict(own, q, own.samples)[0]
        return power_over_time(y, self.pieces)[:, : self.bins] if np.all(np.isfinite(y)) else None

    def distances(self, modelled: FloatArray | None, scales: Sequence[float]) -> list[float]:
        """Return how far it is off if it were to be multiplied by each scale; inf where that cannot be said."""
        if modelled is None:
            return [math.inf] * len(scales)
        return [spectral_distance(self.power, modelled / scale**2, self.noise) for scale in scales]

    def distances_behind(self, modelled: FloatArray | None, cut_offs_hz: Sequence[float]) -> list[float]:
        """Return how far it is off if it passed a low-pass, noise and all, for each cut-off, Hz."""
        if modelled is None:
            return [math.inf] * len(cut_offs_hz)
        size = self.target.samples // self.pieces
        f = (np.arange(modelled.shape[-1]) + SERIES.lowest_bin) * self.target.base.sample_rate_hz / size
        passed = [1.0 / (1.0 + (f / one) ** (2 * ORDER)) for one in cut_offs_hz]
        return [spectral_distance(self.power, modelled * part, self.noise) for part in passed]


def is_looked_at(target: Target) -> bool:
    """Tell whether a record's torque under a command is there in enough samples for spectra of its parts."""
    enough = target.samples >= FEWEST_SAMPLES and target.base.sample_rate_hz >= SLOWEST_HZ
    driven = target.leading.quantity == "torque" and not isinstance(target.command, MeasuredCommand)
    return enough and driven and samples_of(target, 1.0) < target.samples  # of what never steps no line tells


def sight_of(target: Target) -> RecordSight:
    """Return the first steps of a record, its own parameters at their values."""
    rate, base = target.base.sample_rate_hz, target.base
    rest = max(round((target.time_offset.value - base.start_s) * rate), 0)
    steps = max(samples_of(target, STEPS), rest + round(LEAST_S * rate))
    samples = min(steps, rest + round(MOST_S * rate), target.samples)
    pieces = 1 if _is_constant(target.command) else max(round(samples / rate / PIECE_S), 1)
    return RecordSight(target.beginning(samples), target, pieces)


def _is_constant(command: Command) -> bool:
    rates = command.rate.rates
    return all(rate == rates[0] for rate in rates)


def _times(rate: RateProfile, factor: float) -> RateProfile:
    return RateProfile(rate.times_s, tuple(factor * one for one in rate.rates))


def own_rates(sight: RecordSight) -> list[RateProfile]:
    """Return the rates that a record's own lines tell where they are at no part of the one declared."""
    own = sight.own
    if own is None or is_part(own, sight):
        return []
    sign = math.copysign(1.0, max(sight.command.rate.rates, key=abs))
    if own.is_constant and own.stepping == "full":
        return [_times(own.profile, sign)]
    factors = [part * own.repetition_hz / own.rate for part in PARTS] if own.is_constant else PARTS[:2]
    return [_times(_to_the_end(own.profile, sight.whole.base.duration_s), sign * factor) for factor in factors]


def _to_the_end(rate: RateProfile, seconds: float) -> RateProfile:
    """Return a straight line of the rate from the start to the end of a record."""
    if len(rate.rates) == 1:
        return rate
    (_, until), (first, last) = rate.times_s, rate.rates
    return RateProfile.through([(0.0, first), (seconds, first + (last - first) * seconds / until)])


def contradicts(sight: RecordSight) -> bool:
    """Tell whether a record's own lines speak against its declaration: another rate, or full steps and microsteps."""
    own, coarse = sight.own, sight.command.microsteps <= COARSE
    if own is None:
        return False
    return not is_part(own, sight) or (own.stepping != "" and (own.stepping == "full") != coarse)


def is_driven_so(sight: RecordSight, taken: Reading, multiples: Sequence[float]) -> bool:
    """Tell whether a record whose own lines are those of full steps has them at such multiples of the rate read."""
    own, command = sight.own, command_as_read(sight.command, taken)
    if own is None or own.stepping != "full" or command.microsteps > COARSE:
        return True
    rate = max(abs(rate) for rate in command.rate.rates) * command.microsteps
    return own.is_constant and any(abs(own.rate / rate / one - 1.0) < SAME_RATE for one in multiples)


def is_doubtful_rate(sight: RecordSight, taken: Reading) -> bool:
    """Tell whether half or twice the rate that is read would explain the record's lines as well."""
    if taken.rate is None:
        return False
    if taken.swapped is None:
        return len(own_rates(sight)) > 1
    declared, read = (max(abs(rate) for rate in rate.rates) for rate in (sight.command.rate, taken.rate))
    same = command_as_read(sight.command, taken).microsteps == sight.command.microsteps
    related = any(abs(declared / read / one - 1.0) < SAME_RATE for one in REPEATS)
    return same and related and not is_driven_so(sight, taken, FULL_STEPS[:1])


def is_part(own: SuggestedRate, sight: RecordSight) -> bool:
    """Tell whether a record may suggest what it does at the rate declared."""
    command, declared = sight.command, sight.fastest
    if own.is_constant != _is_constant(command):
        return False
    if command.microsteps == 1 and own.stepping == "full":
        return any(abs(own.rate / declared / one - 1.0) < SAME_RATE for one in FULL_STEPS)
    repeats = declared / (own.repetition_hz if own.is_constant else own.rate)
    return any(abs(repeats / one - 1.0) < (SAME_RATE if own.is_constant else SAME_END) for one in REPEATS)
