"""One disturbance: the parameters that records get for it, from where it is none; put into a problem, taken out."""

from __future__ import annotations

import statistics
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import CAMPAIGN, key_in_record
from mechid.campaign.identify_options import MAINS
from mechid.campaign.record_tables import OWN
from mechid.campaign.test_stand_entry import KEY as TEST_STAND
from mechid.command import MeasuredCommand
from mechid.identification.output_error.problem import Problem, transfer_coordinates
from mechid.identification.output_error.record_parameters import determines_mean
from mechid.identification.output_error.target import Target, is_time_offset
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism

SAME_LINE_HZ = 1e-6
"""Frequencies that differ by no more are one line: rounding."""
SAME_MULTIPLE_HZ = 10.0
"""Lines of the grids' multiples are a multiple of this apart, and each is much nearer to it."""
MAINS_PREFIX = "mains:"


@dataclass(frozen=True)
class Disturbance:
    """What records have beside the mechanism.

    Attributes
    ----------
    name : str
        As `estimate.json` names it, ``"clock"`` or ``"record.voltage"``.
    words : str
        What it is.
    own : mapping of record to tuple of Parameter
        What each record gets, free, at the value at which the disturbance is none, with a prior. Records may share one.
    lines_hz : mapping of record to tuple of float
        Lines that are projected out of a record's leading channel, with offset and drift.
    """

    name: str
    words: str
    own: Mapping[str, tuple[Parameter, ...]] = field(default_factory=dict)
    lines_hz: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def mains_hz(self) -> float | None:
        """Nominal frequency of the mains whose hum it is; None where it is something else."""
        grid = self.name.removeprefix(MAINS_PREFIX).removesuffix("Hz")
        return float(grid) if self.lines_hz and self.name.startswith(MAINS_PREFIX) else None

    @property
    def seen_hz(self) -> float | None:
        """Frequency of the mains as it was seen; None where it is something else."""
        grid = self.mains_hz
        if grid is None:
            return None
        every = [hz / round(hz / grid) for lines in self.lines_hz.values() for hz in lines]
        return statistics.median(every) if every else None

    @property
    def records(self) -> tuple[str, ...]:
        """The records that it is in."""
        return (*self.own, *(name for name, lines in self.lines_hz.items() if lines))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All its parameters, one that is shared once."""
        return tuple({p.name: p for own in self.own.values() for p in own}.values())

    def frees_as(self, other: Disturbance) -> bool:
        """Tell whether another one frees the same: a clock of all records and one of each."""
        mine, others = ({p.declaration for p in one.parameters} for one in (self, other))
        return self.name == other.name or not mine.isdisjoint(others)

    @property
    def dof(self) -> int:
        """Degrees of freedom: a mean of what every record has of its own that none tells is the mechanism's."""
        replaced = {p.replaces for p in self.parameters if p.replaces and not determines_mean(p)}
        return len(self.parameters) - len(replaced) + 2 * sum(map(len, self.lines_hz.values()))

    def toml(self, values: Mapping[str, float]) -> str:
        """Return the tables that declare it at some values, for the end of a campaign file."""
        lines: list[str] = []
        shared = [p for p in self.parameters if _is_shared(p)]
        if shared:
            lines += [f"[[{CAMPAIGN}]]", *(f"{p.declaration.key} = {_entry(p, values[p.name])}" for p in shared), ""]
        if self.seen_hz:
            lines += [f"[[{CAMPAIGN}]]", f"{MAINS} = {self.seen_hz!r}", ""]
        for record, own in self.own.items():
            entries = [_line(key_in_record(p.name), _entry(p, values[p.name])) for p in own if p not in shared]
            lines += [f"[[{OWN}]]", f'record = "{record}"', *entries, ""] if entries else []
        keys = (key_in_record(p.name) for p in self.parameters if not _is_shared(p))
        tables = sorted({key.rpartition(".")[0] for key in keys if "." in key})
        return "\n".join([*(f"# The mechanism file needs a table [{table}]." for table in tables), *lines])


@dataclass(frozen=True)
class Found:
    """A disturbance that records ask for, and what a fit with it explains more than one without.

    Attributes
    ----------
    disturbance : Disturbance
    chi_square : float
        By how much the sum of squares falls, each record's samples counted for what they are worth.
    share : float
        Of what the records hold beyond their noise.
    """

    disturbance: Disturbance
    chi_square: float
    share: float


def with_disturbances(problem: Problem, some: Iterable[Disturbance]) -> Problem:
    """Return a problem with the parameters of some disturbances free, their priors counted; its start has none of them.

    A point of it is that of the problem without, by `transfer_coordinates`.
    """
    some = tuple(some)
    targets = tuple(_disturbed_target(target, some) for target in problem.targets)
    there = {t.name for t in targets}
    own = [p for one in some for name, parameters in one.own.items() if name in there for p in parameters]
    priors = {p.name: (p.value, p.sigma) for p in own if p.sigma}
    return replace(problem, targets=targets, priors={**problem.priors, **priors})


def without(problem: Problem, q: FloatArray, some: Iterable[Disturbance]) -> tuple[Problem, FloatArray]:
    """Return a problem, and its point, without some disturbances that were put into it."""
    some = tuple(some)
    lost = {p.name: p for one in some for p in one.parameters}
    targets = tuple(_without_lines(replace(t, own=_kept(t.own, lost)), some) for t in problem.targets)
    priors = {name: prior for name, prior in problem.priors.items() if name not in lost}
    other = replace(problem, targets=targets, priors=priors)
    return other, transfer_coordinates(problem, q, other)


def _without_lines(target: Target, some: Sequence[Disturbance]) -> Target:
    lost = _lines_of(target.name, some)
    if not lost:
        return target
    rate = target.base.sample_rate_hz
    kept = tuple(t for t in target.leading.turns if min(abs(t * rate - hz) for hz in lost) > SAME_LINE_HZ)
    return replace(target, channels=(replace(target.leading, turns=kept), *target.channels[1:]))


def _kept(own: Sequence[Parameter], lost: Mapping[str, Parameter]) -> tuple[Parameter, ...]:
    """Return a record's parameters without those lost; a time offset, which every record has, is known again."""
    kept = (p for p in own if p.name not in lost or is_time_offset(p))
    return tuple(
        Parameter(name=p.name, value=lost[p.name].value, declaration=p.declaration) if p.name in lost else p
        for p in kept
    )


def lacking_tables(mechanism: Mechanism, some: Iterable[Disturbance]) -> frozenset[str]:
    """Return the tables that a mechanism lacks and in which values of single records replace its own: of a gain."""
    replaced = {p.replaces for one in some for p in one.parameters if p.replaces}
    return frozenset(name.rpartition(".")[0] for name in replaced - mechanism.parameters.keys())


def disturbed_campaign(campaign: Campaign, some: Sequence[Disturbance]) -> Campaign:
    """Return a campaign whose records have the parameters of some disturbances, as if its file declared them."""
    if not some:
        return campaign
    return replace(campaign, records=tuple(_disturbed_record(record, some) for record in campaign.records))


def _disturbed_record(record: CampaignRecord, some: Sequence[Disturbance]) -> CampaignRecord:
    shared = [p for one in some for p in one.parameters if _is_shared(p)]
    return with_own(record, {p.name: p for p in (*shared, *_of(record.name, some).values())}.values())


def lines_of(problem: Problem) -> set[float]:
    """Return the lines in Hz that a problem projects out of any record."""
    return {turns * t.base.sample_rate_hz for t in problem.targets for turns in t.leading.turns}


def lines_by_record(problem: Problem, records: Iterable[str]) -> dict[str, tuple[float, ...]]:
    """Return the lines in Hz to be projected out of each of some records.

    A record that the problem does not have gets those that its records have in common, the median of each.
    """
    own = {t.name: tuple(turns * t.base.sample_rate_hz for turns in t.leading.turns) for t in problem.targets}
    by_whole: dict[int, list[float]] = {}
    for hz in (hz for lines in own.values() for hz in lines):
        by_whole.setdefault(round(hz / SAME_MULTIPLE_HZ), []).append(hz)
    common = tuple(statistics.median(some) for _, some in sorted(by_whole.items()))
    return {name: own.get(name, common) for name in records}


def with_lines(record: CampaignRecord, lines_hz: Collection[float]) -> CampaignRecord:
    """Return a record of whose leading channel further lines are projected out, as far as its sampling lets them be."""
    if not lines_hz:
        return record
    rate = record.data.sample_rate_hz if record.data else 0.0
    further = {hz for hz in lines_hz if hz < 0.5 * rate}
    return replace(
        record,
        matches=tuple(
            replace(m, lines_hz=tuple(sorted({*m.lines_hz, *further}))) if m.quantity == record.leading else m
            for m in record.matches
        ),
    )


def with_own(record: CampaignRecord, own: Iterable[Parameter]) -> CampaignRecord:
    """Return a record with further parameters of its own, or others in place of those it has.

    What all share is for those alone that have no clock of their own: a record that its own channels drive has none.
    """
    alone = isinstance(record.command, MeasuredCommand) or (record.clock and not _is_shared(record.clock))
    mine = {p.name: p for p in own if not (alone and _is_shared(p))}
    return replace(record, parameters=_joined(record.parameters, mine))


def _is_shared(parameter: Parameter) -> bool:
    return parameter.name.startswith(f"{CAMPAIGN}.")


def _disturbed_target(target: Target, some: Sequence[Disturbance]) -> Target:
    own, lines = _of(target.name, some), _lines_of(target.name, some)
    if lines:
        turns = tuple(hz / target.base.sample_rate_hz for hz in lines)
        leading = replace(target.leading, turns=(*target.leading.turns, *turns))
        target = replace(target, channels=(leading, *target.channels[1:]))
    if not own:
        return target
    held = replace(target, own=tuple(p for p in target.own if p.name not in own))
    return replace(held.add_parameters(*own.values()), own=_joined(target.own, own))


def _of(record: str, some: Sequence[Disturbance]) -> dict[str, Parameter]:
    return {p.name: p for one in some for p in one.own.get(record, ())}


def _lines_of(record: str, some: Sequence[Disturbance]) -> tuple[float, ...]:
    return tuple(hz for one in some for hz in one.lines_hz.get(record, ()))


def _joined(declared: Sequence[Parameter], own: Mapping[str, Parameter]) -> tuple[Parameter, ...]:
    """Return parameters with those of disturbances in their places, further ones behind."""
    further = (p for name, p in own.items() if name not in {q.name for q in declared})
    return (*(own.get(p.name, p) for p in declared), *further)


def _line(key: str, entry: str) -> str:
    return f"{TEST_STAND} = {{ {key} = {entry} }}" if "." in key else f"{key} = {entry}"


def _entry(p: Parameter, value: float) -> str:
    sigma = f", sigma = {p.sigma!r}" if p.sigma else ""
    return f"{{ value = {value!r}, min = {p.min!r}, max = {p.max!r}{sigma} }}"
