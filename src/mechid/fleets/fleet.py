"""Fleet: identification of its campaigns, and joint statistics of their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from mechid.display import DisplayedResult
from mechid.errors import InputFileError
from mechid.fleets.changes import Change, MeanChange, changes, mean_change
from mechid.fleets.estimates import Estimate, estimate_of, is_of_interest
from mechid.fleets.groups import GroupDifference, group_difference
from mechid.fleets.members import Members
from mechid.fleets.observations import Observations, average_by_unit, collect_observations
from mechid.fleets.outliers import Standing
from mechid.fleets.significance import FdrResult, apply_fdr
from mechid.fleets.spread import Spread, spread
from mechid.fleets.trends import Trend, first_day, remove_trend, trend
from mechid.fleets.unit_run import EstimateOrigin, UnitRun, ignore, run_unit, task_of
from mechid.identification.computation.parallel import Done, is_external, map_tasks
from mechid.identification.computation.progress import Tell
from mechid.identification.result.fit_file import read_numbers
from mechid.locks import hold_folder

UNITS_NAME = "units"
"""Folder of the campaigns' own results."""


@dataclass(frozen=True, kw_only=True)
class FleetParameter:
    """Parameter over the fleet.

    Attributes
    ----------
    observed : Observations
        Values that count.
    level : Observations
        Values for comparing units, with the trend `along` removed and without those of a later state.
    lacking : tuple of str
        Labels of the campaigns whose mechanism file lacks the parameter; if there are any, there is no spread.
    spread : Spread or None
        None if fewer than two units count, or if some lack the parameter.
    along : Trend or None
        Removed trend, the most significant one found.
    equal_q : float
        Least false discovery rate at which the units differ by more than their errors; NaN if not tested.
    differs : bool
    outliers : tuple of Standing
    """

    observed: Observations
    level: Observations
    lacking: tuple[str, ...]
    spread: Spread | None
    along: Trend | None
    equal_q: float
    differs: bool
    outliers: tuple[Standing, ...]

    @property
    def name(self) -> str:
        """Dotted name; a list entry is identified by its period or order."""
        return self.observed.name


@dataclass(frozen=True, kw_only=True, repr=False)
class Fleet(DisplayedResult):
    """Joint result of many campaigns.

    Attributes
    ----------
    asked : Members
        The campaigns and the requested comparisons.
    runs : tuple of UnitRun
        One per campaign, in order.
    estimates : tuple of Estimate or None
        None for a campaign without an estimate.
    parameters : tuple of FleetParameter
        Parameters that any campaign estimates or held, and known ones whose value differs between campaigns.
    trends, groups, changes, mean_changes : tuple of FdrResult
        Each is a separate family of tests.
    folder : Path
        Folder of the results of its campaigns.
    """

    asked: Members
    runs: tuple[UnitRun, ...]
    estimates: tuple[Estimate | None, ...]
    parameters: tuple[FleetParameter, ...]
    trends: tuple[FdrResult[Trend], ...]
    groups: tuple[FdrResult[GroupDifference], ...]
    changes: tuple[FdrResult[Change], ...]
    mean_changes: tuple[FdrResult[MeanChange], ...]
    folder: Path = Path()

    @property
    def failed(self) -> tuple[str, ...]:
        """Labels of the campaigns without a usable estimate."""
        pairs = zip(self.asked.members, self.estimates, strict=True)
        return tuple(m.label for m, e in pairs if e is None or not e.grade.good)


def make_fleet(
    asked: Members,
    out: Path,
    *,
    seed: int = 0,
    workers: int | None = None,
    complete: bool = False,
    say: Tell = ignore,
) -> Fleet:
    """Identify the campaigns of a fleet and evaluate them together; see `mechid.fleet`."""
    with hold_folder(out) as hold:
        tasks = [task_of(m, out / UNITS_NAME, seed, workers, complete=complete, hold=hold) for m in asked.members]

        def report(done: Sequence[Done[UnitRun]]) -> None:
            for number, run, _ in done:
                say(f"{tasks[number].label}: {run.words}")

        # A callback cannot be sent to another process.
        identified = run_unit if is_external() else partial(run_unit, say=say)
        # One campaign at a time: each identification uses all workers itself.
        return replace(fleet_of(asked, map_tasks(identified, tasks, 1, report)), folder=out)


def fleet_of(asked: Members, runs: Sequence[UnitRun]) -> Fleet:
    """Evaluate the estimates of a fleet together; runs are in the order of its members."""
    read = [_read(run) for run in runs]
    estimates = tuple(estimate for estimate, _ in read)
    rate, lacking = asked.false_discovery_rate, _missing_by_parameter(asked, estimates)
    seen = {name: collect_observations(name, asked.members, estimates) for name in lacking}
    days = {name: first_day(asked.members, name) for name in asked.covariates}
    # Later states of a pair would mix changes of a unit with differences between units.
    base = {name: o.of(asked.baseline) for name, o in seen.items()}
    lines = [t for o in base.values() for name in asked.covariates if (t := trend(o, name, days[name]))]
    trends = apply_fdr(lines, rate, lambda one: one.p_value)
    along = _clearest_trends(trends)
    level = {n: remove_trend(o, t, days[t.covariate]) if (t := along.get(n)) else o for n, o in base.items()}
    units = {n: average_by_unit(o) for n, o in level.items() if o.members}
    groups = [g for n, each in units.items() if (g := group_difference(n, each, asked.members))]
    changed = [changes(o, states) for o in seen.values() for states in asked.before_after]
    means = [m for each in changed if (m := mean_change(each))]
    spreads = {n: spread(each) for n, each in units.items() if not lacking[n]}
    return Fleet(
        asked=asked,
        runs=tuple(run for _, run in read),
        estimates=estimates,
        parameters=_parameters(seen, level, lacking, spreads, along, rate),
        trends=trends,
        groups=apply_fdr(groups, rate, lambda one: one.p_value),
        changes=apply_fdr([c for each in changed for c in each], rate, lambda one: one.p_value),
        mean_changes=apply_fdr(means, rate, lambda one: one.p_value),
    )


def _read(run: UnitRun) -> tuple[Estimate | None, UnitRun]:
    """Return the estimate that a run left; a read error is reported in the run."""
    if run.how is EstimateOrigin.NONE:
        return None, run
    try:
        return estimate_of(read_numbers(run.folder)), run
    except InputFileError as error:
        return None, UnitRun(how=EstimateOrigin.NONE, folder=run.folder, said=str(error), seconds=run.seconds)


def _missing_by_parameter(asked: Members, estimates: Sequence[Estimate | None]) -> dict[str, tuple[str, ...]]:
    """Return the labels of the campaigns that lack a parameter, for each parameter of interest."""
    there = [(m.label, e) for m, e in zip(asked.members, estimates, strict=True) if e is not None]
    names = dict.fromkeys(name for _, e in there for name in e.values)
    shown = (name for name in names if is_of_interest([e for _, e in there], name))
    return {name: tuple(label for label, e in there if name not in e.values) for name in shown}


def _clearest_trends(trends: Sequence[FdrResult[Trend]]) -> dict[str, Trend]:
    """Return for each parameter the trend with the least p-value among those found."""
    # Descending p-values: the dictionary keeps the last entry of a name, the most significant one.
    found = sorted((one.result for one in trends if one.found), key=lambda t: -t.p_value)
    return {t.name: t for t in found}


def _parameters(
    seen: Mapping[str, Observations],
    level: Mapping[str, Observations],
    lacking: Mapping[str, tuple[str, ...]],
    spreads: Mapping[str, Spread | None],
    along: Mapping[str, Trend],
    rate: float,
) -> tuple[FleetParameter, ...]:
    made = {name: s for name, s in spreads.items() if s is not None}
    equal = dict(zip(made, apply_fdr(list(made.values()), rate, lambda s: s.equal_p), strict=True))
    off = fleet_outliers({name: s.standings for name, s in made.items()}, rate)
    return tuple(
        FleetParameter(
            observed=o,
            level=level[name],
            lacking=lacking[name],
            spread=made.get(name),
            along=along.get(name),
            equal_q=equal[name].q if name in equal else float("nan"),
            differs=name in equal and equal[name].found,
            outliers=off.get(name, ()),
        )
        for name, o in seen.items()
    )


def fleet_outliers(standings: Mapping[str, tuple[Standing, ...]], rate: float) -> dict[str, tuple[Standing, ...]]:
    """Return the outlying units of each parameter, from the candidates.

    The farthest unit of each parameter is one test of the family, with a factor for the number of units removed in
    sequence: without it 9 % of fleets without outliers had one at a rate of 5 %. If it is a finding, the outliers are
    the units below the rate times the share of such parameters (Benjamini, Bogomolov, J. R. Stat. Soc. B 76 (2014)
    297).
    """
    named = [(name, each) for name, each in standings.items() if each]
    chosen = [one.result for one in apply_fdr(named, rate, lambda one: _adjusted_p(one[1], one[1][0])) if one.found]
    level = rate * len(chosen) / max(len(named), 1)
    return {name: tuple(one for one in each if _adjusted_p(each, one) <= level) for name, each in chosen}


def _adjusted_p(each: Sequence[Standing], one: Standing) -> float:
    """Return the p-value of a unit, with a factor for the number of units removed."""
    return min(one.p_value * len(each), 1.0)
