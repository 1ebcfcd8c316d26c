"""Design of the next test: planned records, more informative ones in the same time, and rates to avoid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.command import Command, RateProfile
from mechid.command.stepping import FIXED_MICROSTEPS, STEPPINGS
from mechid.designs.alternatives import Group
from mechid.designs.candidates import candidates, usual_rates
from mechid.designs.criterion import Criterion, criterion_at
from mechid.designs.design_file import DesignOptions
from mechid.designs.group_separation import Separation, separation
from mechid.designs.information import informations
from mechid.designs.loss_table import LossRow, loss_table
from mechid.designs.planned_record import PlannedRecord, planned_records
from mechid.designs.prior_knowledge import PriorKnowledge, after_fit, before_test
from mechid.designs.rate_map import RateMap, rate_map
from mechid.designs.record_set import RecordSet, errors_by_record, record_set
from mechid.designs.screening import Screening, screen
from mechid.designs.selection import Choice, Pool, select
from mechid.designs.settings import DESIGN
from mechid.designs.step_loss import Margins, is_stepper, margins
from mechid.designs.trust import departing_share
from mechid.display import DisplayedResult
from mechid.errors import FitError, UsageError, did_you_mean
from mechid.identification.computation.parallel import map_tasks, one_core_algebra
from mechid.identification.computation.workforce import working_on
from mechid.identification.result.fit import Optimum
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, eq=False, repr=False)
class Design(DisplayedResult):
    """Result of `mechid design`.

    Attributes
    ----------
    campaign : Campaign
    options : DesignOptions
    knowledge : PriorKnowledge
    planned : RecordSet
        The campaign's own records; after a fit no new records, only present knowledge.
    chosen : RecordSet
    trail : tuple of float
        Criterion before the first chosen record and after each.
    errors_by_record : mapping of str to tuple of float
        Standard error of each parameter at the same places, as the median over the possible mechanisms.
    candidates : tuple of PlannedRecord
        All records to choose from, the campaign's own first.
    objections : tuple of str
        Why a candidate cannot be driven, empty if it can.
    peaks : (candidates,)
        Expected peak torque, N m.
    departing : (candidates,)
        Share of draws in which a stick-slip event changes, so that the record is less informative than predicted.
    maps : tuple of RateMap
    losses : tuple of LossRow
    margins : mapping of str to Margins
        For the planned and chosen records.
    warnings : tuple of str
    fit_digest : str
        `Fit.mechanism_digest` of the fit that it follows; empty before a test.
    separation : Separation or None
        Separation of alternative explanations of a diagnosis; None without any.
    """

    campaign: Campaign
    options: DesignOptions
    knowledge: PriorKnowledge
    planned: RecordSet
    chosen: RecordSet
    trail: tuple[float, ...]
    errors_by_record: dict[str, tuple[float, ...]]
    candidates: tuple[PlannedRecord, ...]
    objections: tuple[str, ...]
    peaks: FloatArray
    departing: FloatArray
    maps: tuple[RateMap, ...]
    losses: tuple[LossRow, ...]
    margins: dict[str, Margins]
    warnings: tuple[str, ...]
    separation: Separation | None = None
    fit_digest: str = ""

    @property
    def total_s(self) -> float:
        """Available test time, s."""
        return self.options.limits.total_s or (
            DESIGN.next_s if self.knowledge.known is not None else self.planned.seconds
        )

    @property
    def mechanism(self) -> Mechanism:
        """Mechanism at the assumed values."""
        return self.knowledge.space.mechanism


def make_design(
    campaign: Campaign,
    options: DesignOptions | None = None,
    *,
    fit: Optimum | None = None,
    rivals: Sequence[Group] = (),
    workers: int = 1,
    executor: Executor | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Design:
    """Return the design of the next test.

    Parameters
    ----------
    campaign : Campaign
        Its records need no files.
    options : DesignOptions or None
    fit : Optimum or None
        Finished fit of the campaign, whose records exist already.
    rivals : sequence of Group
        Alternative explanations of the fit's records; records that separate them are chosen first.
    workers : int
        Number of threads.
    executor : concurrent.futures.Executor or None
        External executor, as `distributed.Client.get_executor()`; None uses threads.
    say : callable
        Called with lines of progress.

    Raises
    ------
    FitError
        There is nothing to estimate, or the records cannot be simulated.
    UsageError
        The options name a missing item, or the campaign does not consist of step commands.
    """
    options = options or DesignOptions()
    if not campaign.mechanism.free:
        raise FitError(f"{campaign.mechanism_path}: nothing to estimate: every parameter is a bare number")
    if not is_stepper(campaign.mechanism):
        raise UsageError(f"{campaign.mechanism_path}: a design is made of step commands; this assembly has none")
    count, seed = options.mechanisms, options.seed
    with one_core_algebra(), working_on(executor):
        here = after_fit(fit, count, seed) if fit else before_test(campaign, count, seed)
        return _DesignBuilder(campaign, options, here, rivals, workers, say).design()


class _DesignBuilder:
    """State and steps of the computation of a design."""

    def __init__(
        self,
        campaign: Campaign,
        options: DesignOptions,
        here: PriorKnowledge,
        rivals: Sequence[Group],
        workers: int,
        say: Callable[[str], None],
    ) -> None:
        self.campaign, self.options, self.here, self.workers, self.say = campaign, options, here, workers, say
        self.rivals = rivals
        noise = options.recording.noise_Nm or here.sigma
        self.own, self.warnings = planned_records(campaign, replace(options.recording, noise_Nm=noise))
        self.mechanisms = [here.space.at(q) for q in here.points]

    def design(self) -> Design:
        criterion = criterion_at(self.here.space, self.here.points, self.options.criterion, self.options.over)
        pool = self._pool()
        self.say(f"{len(pool)} records to choose from, {len(self.mechanisms)} mechanisms: which of them can be driven")
        screened = screen(self.mechanisms, pool, self.workers)
        objections = screened.objections(self.options.limits.risk, self.options.limits.torque_Nm)
        self.say("information of each record")
        information = informations(self.here.space, pool, self.here.points, self.workers)
        # A record in which a mechanism loses steps is of no use if that mechanism is the true one.
        information[screened.lost] = 0.0
        first = len(self.own)
        planned = [] if self.here.known is not None else list(range(first))
        self.say("reliability of each record's information")
        departing = self._departing_shares(pool, information)
        near_threshold = [_objection(share, self.options.limits.departing) for share in departing]
        objections = [o or h for o, h in zip(objections, near_threshold, strict=True)]
        expected_information = information * (1.0 - departing)[:, None, None]
        apart = self._separation(pool, screened, objections)
        choice = self._choose(pool, expected_information, objections, criterion, apart.chosen if apart else ())
        chosen = [pool[k] for k in choice.chosen]
        self.say("rates that lose steps, amplitude over the rate")
        maps, losses = self._maps(), self._losses()
        records = [pool[k] for k in dict.fromkeys((*planned, *choice.chosen))]
        record_margins = map_tasks(partial(_margins, self.mechanisms[0]), records, self.workers)
        return Design(
            campaign=self.campaign,
            options=self.options,
            knowledge=self.here,
            planned=self._set([pool[k] for k in planned], expected_information[:, planned], criterion),
            chosen=self._set(_number_duplicates(chosen), expected_information[:, list(choice.chosen)], criterion),
            trail=choice.trail,
            errors_by_record=errors_by_record(self.here, expected_information[:, list(choice.chosen)]),
            candidates=tuple(pool),
            objections=tuple(objections),
            peaks=screened.peak[0],
            departing=departing,
            maps=maps,
            losses=losses,
            margins=dict(zip((r.name for r in records), record_margins, strict=True)),
            warnings=(*self.warnings, *self._step_loss_warnings(screened, planned)),
            separation=apart,
        )

    def _pool(self) -> list[PlannedRecord]:
        """Return the campaign's own records followed by the candidates, without duplicate names."""
        made = candidates(self.options.candidates, self.mechanisms[0], self.own[0])
        mine = {r.name for r in self.own}
        others = [replace(r, name=f"{r.name}_new") if r.name in mine else r for r in made]
        # A candidate equal to an own record would let the selection take one record twice.
        same = {(r.command, r.duration_s) for r in self.own}
        return [*self.own, *(r for r in others if (r.command, r.duration_s) not in same)]

    def _departing_shares(self, pool: Sequence[PlannedRecord], information: FloatArray) -> FloatArray:
        """Return the share of draws, (records,), in which the cost of a record departs from its quadratic prediction.

        The draws have the covariance that remains when the test time is spent evenly on all records.
        """
        here, seed, seconds = self.here, self.options.seed, self._seconds(pool)
        spent = self._total_s(seconds) / float(seconds.sum())
        reference = here.before + spent * information.sum(axis=1)
        return departing_share(here.space, pool, here.points, information, reference, seed=seed, workers=self.workers)

    def _seconds(self, pool: Sequence[PlannedRecord]) -> FloatArray:
        return np.array([r.duration_s + self.options.limits.between_s for r in pool])

    def _total_s(self, seconds: FloatArray) -> float:
        usual = DESIGN.next_s if self.here.known is not None else float(seconds[: len(self.own)].sum())
        return self.options.limits.total_s or usual

    def _separation(
        self, pool: Sequence[PlannedRecord], screened: Screening, objections: Sequence[str]
    ) -> Separation | None:
        """Return the separation of alternatives in the time that the required records leave."""
        if not self.rivals:
            return None
        self.say("how clearly each record would tell rival explanations apart")
        limits, seconds = self.options.limits, self._seconds(pool)
        mechanisms = [
            m.problem.space.at(m.problem.coordinates.of_mechanism(m.q)) for g in self.rivals for m in g.models
        ]
        lost = screened.lost[0] | screen(mechanisms, pool, self.workers).lost.any(axis=0)
        kept = float(sum(seconds[self._index(name)] for name in limits.keep))
        return separation(
            self.campaign,
            self.rivals,
            pool,
            driven=~lost,
            allowed=np.array([not o for o in objections]),
            seconds=seconds,
            total_s=self._total_s(seconds) - kept,
            workers=self.workers,
        )

    def _choose(
        self,
        pool: Sequence[PlannedRecord],
        information: FloatArray,
        objections: Sequence[str],
        criterion: Criterion,
        first: Sequence[int],
    ) -> Choice:
        limits, seconds = self.options.limits, self._seconds(pool)
        kept = list(dict.fromkeys([*(self._index(name) for name in limits.keep), *first]))
        before = np.broadcast_to(self.here.before, (len(self.here.points), *self.here.before.shape))
        allowed, total_s = np.array([not o for o in objections]), self._total_s(seconds)
        choice = select(Pool(information, before, seconds, total_s, allowed, limits.most_of_one), criterion, kept)
        if not choice.chosen:
            why = next((f", as {r.name}: {o}" for r, o in zip(pool, objections, strict=True) if o), "")
            out = sum(map(bool, objections))
            raise UsageError(
                f"limits: none of {len(pool)} records fits into {total_s:g} s; {out} are left out{why}; "
                "widen the limits, or give other candidates"
            )
        return choice

    def _index(self, name: str) -> int:
        names = [r.name for r in self.own]
        if name not in names:
            near = did_you_mean(name, names) or "; there are " + ", ".join(names)
            raise UsageError(f'limits.keep: no record "{name}"{near}')
        return names.index(name)

    def _set(self, records: Sequence[PlannedRecord], information: FloatArray, criterion: Criterion) -> RecordSet:
        between_s = self.options.limits.between_s
        try:
            return record_set(self.here, records, information, criterion, between_s=between_s, workers=self.workers)
        except ArithmeticError as error:
            raise FitError(f"{self.campaign.path}: {error}") from error

    def _commands(self) -> list[Command]:
        """Return one command of each stepping, to be driven at other rates."""
        n, still = self.options.candidates.microsteps, RateProfile.constant(0.0)
        plain = [Command(stepping=s, microsteps=FIXED_MICROSTEPS.get(s, n), rate=still) for s in STEPPINGS]
        return [self.mechanisms[0].command_for(command) for command in plain]

    def _maps(self) -> tuple[RateMap, ...]:
        rates = self.options.candidates.rates or usual_rates(self.mechanisms[0])
        highest = DESIGN.rate_margin * max(rates)
        one = partial(_rate_map, self.mechanisms, highest)
        return tuple(map_tasks(one, self._commands(), self.workers))

    def _losses(self) -> tuple[LossRow, ...]:
        commands = [c for c in self._commands() if c.stepping in self.options.candidates.steppings]
        return loss_table(self.mechanisms[0], commands, self.workers)

    def _step_loss_warnings(self, screened: Screening, planned: Sequence[int]) -> list[str]:
        """Return warnings about the campaign's own records that lose steps."""
        lines = []
        for k in planned:
            share = float(screened.lost[:, k].mean())
            if screened.lost[0, k] or share > self.options.limits.risk:
                believed = "at the values believed" if screened.lost[0, k] else "though not at the values believed"
                lines.append(
                    f"record {self.own[k].name}: loses steps in {100.0 * share:.0f} % of the mechanisms that may be "
                    f"true, {believed}"
                )
        return lines


def _margins(mechanism: Mechanism, record: PlannedRecord) -> Margins:
    return margins(mechanism, record.command, record.duration_s)


def _rate_map(mechanisms: Sequence[Mechanism], highest: float, command: Command) -> RateMap:
    return rate_map(mechanisms[0], mechanisms[1:], command, highest)


def _objection(departing: float, most: float) -> str:
    return f"near a stick/slip threshold in {100.0 * departing:.0f} % of draws" if departing > most else ""


def _number_duplicates(records: Sequence[PlannedRecord]) -> list[PlannedRecord]:
    """Return records with a number appended to repeated names."""
    seen: dict[str, int] = {}
    out = []
    for r in records:
        seen[r.name] = seen.get(r.name, 0) + 1
        out.append(replace(r, name=f"{r.name}_{seen[r.name]}") if seen[r.name] > 1 else r)
    return out
