"""Disturbance of records: its parameters and their null values, and its insertion into and removal from a problem."""

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
"""Largest difference of two frequencies that count as one line, due to rounding."""
SAME_MULTIPLE_HZ = 10.0
"""Spacing of the grids' multiples, to which each line is much closer."""
MAINS_PREFIX = "mains:"


@dataclass(frozen=True)
class Disturbance:
    """Effect on records that is not part of the mechanism.

    Attributes
    ----------
    name : str
        Name in `estimate.json`, such as ``"clock"`` or ``"record.voltage"``.
    words : str
        Description.
    own : mapping of record to tuple of Parameter
        Parameters of each record, free, at their null value, with a prior. Records may share one.
    lines_hz : mapping of record to tuple of float
        Lines that are projected out of a record's leading channel, with offset and drift.
    """

    name: str
    words: str
    own: Mapping[str, tuple[Parameter, ...]] = field(default_factory=dict)
    lines_hz: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def mains_hz(self) -> float | None:
        """Nominal frequency of the mains for hum; None for other disturbances."""
        grid = self.name.removeprefix(MAINS_PREFIX).removesuffix("Hz")
        return float(grid) if self.lines_hz and self.name.startswith(MAINS_PREFIX) else None

    @property
    def seen_hz(self) -> float | None:
        """Measured frequency of the mains for hum; None for other disturbances."""
        grid = self.mains_hz
        if grid is None:
            return None
        every = [hz / round(hz / grid) for lines in self.lines_hz.values() for hz in lines]
        return statistics.median(every) if every else None

    @property
    def records(self) -> tuple[str, ...]:
        """Records that have it."""
        return (*self.own, *(name for name, lines in self.lines_hz.items() if lines))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All its parameters, a shared one once."""
        return tuple({p.name: p for own in self.own.values() for p in own}.values())

    def overlaps(self, other: Disturbance) -> bool:
        """Tell whether another disturbance frees the same, as a common clock and one clock for each record."""
        mine, others = ({p.declaration for p in one.parameters} for one in (self, other))
        return self.name == other.name or not mine.isdisjoint(others)

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        # A mean over all records that the data do not determine is tied to the mechanism's value, which takes one
        # degree.
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
        # The table comes first as a comment, because only the mechanism file can provide it.
        return "\n".join([*(f"# The mechanism file needs a table [{table}]." for table in tables), *lines])


@dataclass(frozen=True)
class FoundDisturbance:
    """Disturbance supported by the data, and the improvement of a fit with it.

    Attributes
    ----------
    disturbance : Disturbance
    chi_square : float
        Reduction of the sum of squares, using effective sample counts.
    share : float
        Reduction as a share of the misfit beyond noise.
    """

    disturbance: Disturbance
    chi_square: float
    share: float


def with_disturbances(problem: Problem, some: Iterable[Disturbance]) -> Problem:
    """Return a problem with the parameters of some disturbances free, with priors, and starting at their null values.

    A point of the problem without them is converted by `transfer_coordinates`.
    """
    some = tuple(some)
    targets = tuple(_disturbed_target(target, some) for target in problem.targets)
    there = {t.name for t in targets}
    own = [p for one in some for name, parameters in one.own.items() if name in there for p in parameters]
    priors = {p.name: (p.value, p.sigma) for p in own if p.sigma}
    return replace(problem, targets=targets, priors={**problem.priors, **priors})


def remove_disturbances(problem: Problem, q: FloatArray, some: Iterable[Disturbance]) -> tuple[Problem, FloatArray]:
    """Return a problem, and its point, with some of its disturbances removed."""
    some = tuple(some)
    lost = {p.name: p for one in some for p in one.parameters}
    targets = tuple(_without_lines(replace(t, own=_remaining_parameters(t.own, lost)), some) for t in problem.targets)
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


def _remaining_parameters(own: Sequence[Parameter], lost: Mapping[str, Parameter]) -> tuple[Parameter, ...]:
    """Return a record's parameters without the removed ones; the time offset of every record is fixed again."""
    kept = (p for p in own if p.name not in lost or is_time_offset(p))
    return tuple(
        Parameter(name=p.name, value=lost[p.name].value, declaration=p.declaration) if p.name in lost else p
        for p in kept
    )


def missing_tables(mechanism: Mechanism, some: Iterable[Disturbance]) -> frozenset[str]:
    """Return the tables that a mechanism lacks and that per-record values need: that of a gain."""
    replaced = {p.replaces for one in some for p in one.parameters if p.replaces}
    return frozenset(name.rpartition(".")[0] for name in replaced - mechanism.parameters.keys())


def disturbed_campaign(campaign: Campaign, some: Sequence[Disturbance]) -> Campaign:
    """Return a campaign whose records have the parameters of some disturbances, as if its file declared them."""
    if not some:
        return campaign
    return replace(campaign, records=tuple(_disturbed_record(record, some) for record in campaign.records))


def _disturbed_record(record: CampaignRecord, some: Sequence[Disturbance]) -> CampaignRecord:
    shared = [p for one in some for p in one.parameters if _is_shared(p)]
    return with_parameters(record, {p.name: p for p in (*shared, *_of(record.name, some).values())}.values())


def lines_of(problem: Problem) -> set[float]:
    """Return the lines in Hz that a problem projects out of any record."""
    return {turns * t.base.sample_rate_hz for t in problem.targets for turns in t.leading.turns}


def lines_by_record(problem: Problem, records: Iterable[str]) -> dict[str, tuple[float, ...]]:
    """Return the lines in Hz to be projected out of each of some records.

    A record that is not in the problem gets the lines common to its records, the median of each.
    """
    own = {t.name: tuple(turns * t.base.sample_rate_hz for turns in t.leading.turns) for t in problem.targets}
    by_whole: dict[int, list[float]] = {}
    for hz in (hz for lines in own.values() for hz in lines):
        by_whole.setdefault(round(hz / SAME_MULTIPLE_HZ), []).append(hz)
    common = tuple(statistics.median(some) for _, some in sorted(by_whole.items()))
    return {name: own.get(name, common) for name in records}


def with_lines(record: CampaignRecord, lines_hz: Collection[float]) -> CampaignRecord:
    """Return a record with further lines projected out of its leading channel, up to half its sample rate."""
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


def with_parameters(record: CampaignRecord, own: Iterable[Parameter]) -> CampaignRecord:
    """Return a record with further record parameters, or others in place of its own ones.

    A shared clock applies only to records without a clock of their own. A record that its own channels drive has none.
    """
    alone = isinstance(record.command, MeasuredCommand) or (record.clock and not _is_shared(record.clock))
    mine = {p.name: p for p in own if not (alone and _is_shared(p))}
    return replace(record, parameters=_merge_parameters(record.parameters, mine))


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
    return replace(held.add_parameters(*own.values()), own=_merge_parameters(target.own, own))


def _of(record: str, some: Sequence[Disturbance]) -> dict[str, Parameter]:
    return {p.name: p for one in some for p in one.own.get(record, ())}


def _lines_of(record: str, some: Sequence[Disturbance]) -> tuple[float, ...]:
    return tuple(hz for one in some for hz in one.lines_hz.get(record, ()))


def _merge_parameters(declared: Sequence[Parameter], own: Mapping[str, Parameter]) -> tuple[Parameter, ...]:
    """Return declared parameters, replaced by those of disturbances of the same name, followed by further ones."""
    further = (p for name, p in own.items() if name not in {q.name for q in declared})
    return (*(own.get(p.name, p) for p in declared), *further)


def _line(key: str, entry: str) -> str:
    return f"{TEST_STAND} = {{ {key} = {entry} }}" if "." in key else f"{key} = {entry}"


def _entry(p: Parameter, value: float) -> str:
    sigma = f", sigma = {p.sigma!r}" if p.sigma else ""
    return f"{{ value = {value!r}, min = {p.min!r}, max = {p.max!r}{sigma} }}"
