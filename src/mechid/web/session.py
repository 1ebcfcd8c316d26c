"""Session of one tab: settings, shown records and running fit, independent of the browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import is_of_start
from mechid.campaign.mechanism_text import mechanism_text
from mechid.errors import UsageError
from mechid.identification.computation.progress import Listener, Progress
from mechid.identification.identify import identify, identify_from
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.web.estimate import Estimate, estimate_of, read_estimated
from mechid.web.fit_run import FitRun, RunState
from mechid.web.followed_run import FollowedRun
from mechid.web.named_effect import NamedEffect
from mechid.web.picture import Effect, Picture, Scene, Stretch, scenes_of
from mechid.web.state import State, campaign_at, first_state
from mechid.web.stored_diagnosis import StoredDiagnosis
from mechid.web.sweep import SweepPicture, sweep_picture

MOST_SHOWN = 4
"""Most records shown together."""
FIRST_LOOK_S = 1.0


@dataclass(frozen=True, eq=False)
class Source:
    """Common initial data of all tabs: a loaded campaign, and its finished fit if there is one.

    `journal` belongs to an identification in the result folder that may be running; `workers` is the number of threads
    of a fit. `diagnosed` is the diagnosis of a campaign with the proposed mechanism: the page starts at its values, and
    each effect has a switch.
    """

    campaign: Campaign
    estimate: Estimate | None = None
    workers: int | None = None
    journal: Path | None = None
    diagnosed: StoredDiagnosis | None = None

    @property
    def effects(self) -> tuple[NamedEffect, ...]:
        """Effects named by the diagnosis."""
        return self.diagnosed.effects if self.diagnosed else ()

    @cached_property
    def scenes(self) -> dict[str, Scene]:
        """Channels that can be shown, by label; shared by tabs until a fit reinterprets a record."""
        return scenes_of(self.campaign)


def _end_of(estimate: Estimate) -> Progress:
    """Return the final report of a fit, with the noise ratios of its records."""
    return Progress(1, 1, "verdict", "all records compared with their noise", None, 0.0, over_noise=estimate.over_noise)


class Session:
    """Session of one tab.

    Parameters
    ----------
    source : Source

    Attributes
    ----------
    state : State
    estimate : Estimate or None
        The latest estimate, from files or from fits of this tab.
    shown : tuple of str
        Labels of the shown channels.
    seconds : float
        Shown duration from the start of each record.
    hand : str
        The active knob.
    compares : bool
        Whether the curves of the estimate are drawn too.
    run : FitRun or None
        The running or the latest fit.
    """

    def __init__(self, source: Source) -> None:
        self.source, self.campaign = source, source.campaign
        self.estimate = source.estimate
        self.state: State = first_state(self.campaign)
        if self.estimate and not source.effects:
            # The initial values are no change that a user could undo.
            self.state = replace(self.state.at(self.estimate.values), past=())
        self.scenes = source.scenes
        self.shown: tuple[str, ...] = tuple(self.scenes)[:1]
        self.seconds = FIRST_LOOK_S
        self.hand = next((q.name for q in self.campaign.mechanism.free), next(iter(self.state.knobs)))
        self.compares = False
        self.run: FitRun | None = None
        self.followed = FollowedRun(source.journal) if source.journal else None
        self.reading: FitRun | None = None
        self._steps: dict[str, int] = {}
        self._compared: dict[tuple[str, float], Picture] = {}

    def turn(self, name: str, value: float, grip: str = "") -> None:
        """Set a knob, which becomes the active one."""
        off = (one for one in self.source.effects if not one.is_on(self.state.now.values))
        along = [own for one in off for own, followed in one.follows.items() if followed == name]
        self.state = self.state.set_value(name, value, grip, along=along)
        self.hand = name

    def switch(self, name: str, *, is_on: bool) -> None:
        """Switch an effect on at its found values, or off at its null values, where no fit changes it."""
        effect = self.source.diagnosed.effect(name) if self.source.diagnosed else None
        if effect is None or effect.why_fixed:
            raise UsageError(f"no effect {name} to switch")
        self.state = self._at(effect.found if is_on else effect.nulls_at(self.state.now.values))
        self.hand = next(iter(effect.nulls))

    def take(self, name: str) -> None:
        """Make a knob the active one without changing it."""
        if name not in self.state.knobs:
            raise UsageError(f"no parameter {name} to take in hand")
        self.hand = name

    def set_free(self, name: str, *, is_free: bool) -> None:
        """Set whether a fit may change a knob."""
        self.state = self.state.with_free(name, is_free=is_free)

    def undo(self) -> None:
        """Undo the last change."""
        self.state = self.state.undo()

    def to_estimate(self) -> None:
        """Set all knobs to the latest estimate, with effects that it lacks switched off."""
        if self.estimate and self.reaches_estimate:
            self.state = self._at(self.values_of(self.estimate))

    def to_file(self) -> None:
        """Set all knobs to the values of the mechanism file, and added terms to their initial values in the fit."""
        files = (self.campaign, self.source.campaign)
        self.state = self._at({q.name: q.value for campaign in files for q in campaign.parameters.values()})

    @property
    def reaches_estimate(self) -> bool:
        """Whether the latest estimate can be set: it has to contain all laws that cannot be switched off."""
        if self.estimate is None:
            return False
        fixed = (one for one in self.source.effects if not one.nulls and not one.is_of_records)
        return all(one.found.keys() <= self.estimate.values.keys() for one in fixed)

    def values_of(self, estimate: Estimate) -> dict[str, float]:
        """Return the values of an estimate, and null values of effects that it lacks."""
        there = {**self.state.now.values, **estimate.values}
        return {name: v for one in self.source.effects for name, v in one.nulls_at(there).items()} | dict(
            estimate.values
        )

    def _at(self, values: Mapping[str, float]) -> State:
        """Return the state at given values, with the parameters of effects free only if the effects are on."""
        was, moved = self.state.now.values, self.state.at(values)
        free = self.state.now.free
        for effect in self.source.effects:
            before, after = effect.is_on(was), effect.is_on(moved.now.values)
            if before != after:
                free = free | effect.free if after else free - effect.found.keys()
        return self.state.at(values, free=free)

    def look(self, names: tuple[str, ...], seconds: float) -> None:
        """Show the first `seconds` of the given channels."""
        unknown = [name for name in names if name not in self.scenes]
        if unknown:
            raise UsageError(f"no record {unknown[0]} to show")
        if not seconds > 0.0:
            raise UsageError(f"{seconds} s is no stretch of a record")
        # The latest choices are kept if more are selected than fit on the page.
        self.shown, self.seconds = names[-MOST_SHOWN:], seconds

    def compare(self, *, is_on: bool) -> None:
        """Set whether the curves of the estimate are drawn too."""
        self.compares = is_on

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism at the current settings."""
        return campaign_at(self.campaign, self.state).mechanism

    def pictures(self) -> dict[str, Picture]:
        """Return the pictures of the shown channels at the current settings."""
        return {name: self._picture(name, self.state) for name in self.shown}

    def estimate_pictures(self) -> dict[str, Picture]:
        """Return the pictures of the shown channels at the estimate."""
        if not self.estimate or not self.reaches_estimate:
            return {}
        at = self.state.at(self.values_of(self.estimate))
        for name in self.shown:
            if (name, self.seconds) not in self._compared:
                self._compared[name, self.seconds] = self._picture(name, at)
        return {name: self._compared[name, self.seconds] for name in self.shown}

    def effects(self) -> dict[str, Effect]:
        """Return the effect of a small step of the active knob on the shown channels."""
        mechanism, knob = self.mechanism, self.state.knobs[self.hand]
        return {name: self.scenes[name].effect(mechanism, knob, self._stretch(name, self.state)) for name in self.shown}

    def sweeps(self, pictures: Mapping[str, Picture]) -> dict[str, SweepPicture]:
        """Return time-frequency pictures of records with a varying step rate."""
        mechanism, scenes = self.mechanism, self.scenes
        return {
            name: sweep_picture(scenes[name], p, mechanism) for name, p in pictures.items() if scenes[name].is_sweep
        }

    def _picture(self, name: str, state: State) -> Picture:
        mechanism = campaign_at(self.campaign, state).mechanism
        return self.scenes[name].picture(mechanism, self._stretch(name, state))

    def _stretch(self, name: str, state: State) -> Stretch:
        """Return the simulated part of a record."""
        own = {q.name: state.now.values.get(q.name, q.value) for q in self.scenes[name].record.parameters}
        if name not in self._steps:
            self._steps[name] = self.scenes[name].steps_needed(self.mechanism)
        return Stretch(self.seconds, own, self._steps[name])

    def mechanism_file(self) -> str:
        """Return the text of mechanism.toml at the current settings.

        Effects that are off are omitted.
        """
        diagnosed, mechanism = self.source.diagnosed, self.mechanism
        return mechanism_text(
            diagnosed.remove_disabled(mechanism, self.state.now.values) if diagnosed else mechanism,
            f"set by hand with mechid explore, from {self.campaign.mechanism_path.name}",
        )

    @property
    def is_fitting(self) -> bool:
        """Whether a fit is running."""
        return self.run is not None and self.run.state is RunState.RUNNING

    @property
    def shown_run(self) -> FitRun | FollowedRun | None:
        """The shown run: that of this tab, or one in another process that was running while the tab was open."""
        return self.run or (self.followed if self.followed and self.followed.is_alive else None)

    @property
    def is_at_catalogue(self) -> bool:
        """Whether all free parameters are at the values of the file and not at an estimate."""
        if self.source.effects:
            # The proposed mechanism file contains found values.
            return False
        now = self.state.now
        begun = {q.name: q.value for q in self.source.campaign.parameters.values()}
        estimated = self.estimate.values if self.estimate else {}
        return all(now.values[name] == begun.get(name) for name in now.free) and not all(
            now.values[name] == estimated.get(name) for name in now.free
        )

    def fit_from_here(self) -> None:
        """Start a fit of the free parameters from the values of the knobs."""
        values, n = dict(self.state.now.values), self.source.workers
        self._begin(lambda campaign, listener: identify_from(campaign, values, workers=n, listener=listener))

    def search(self) -> None:
        """Start an identification with its own search for initial values, as ``mechid identify`` does."""
        self._begin(lambda campaign, listener: identify(campaign, workers=self.source.workers, listener=listener))

    def _begin(self, work: Callable[[Campaign, Listener], Fit]) -> None:
        if self.is_fitting:
            raise UsageError("a fit is at work; cancel it first")
        campaign = self._remove_disabled(campaign_at(self.campaign, self.state))

        def fit_and_judge(listener: Listener) -> Estimate:
            fit = work(campaign, listener)
            listener(Progress(1, 1, "verdict", "all records are simulated and compared with their noise", None, 0.0))
            return estimate_of(fit, campaign, "the last fit of this tab")

        self.run = FitRun(fit_and_judge)
        self.run.start()

    def _remove_disabled(self, campaign: Campaign) -> Campaign:
        """Remove per-record parameters of effects that are off, so that values of the mechanism apply."""
        off = {n for one in self.source.effects if not one.is_on(self.state.now.values) for n in one.follows}
        records = campaign.records
        kept = (replace(r, parameters=tuple(q for q in r.parameters if q.name not in off)) for r in records)
        return replace(campaign, records=tuple(kept)) if off else campaign

    def cancel(self) -> None:
        """Cancel the running fit."""
        if self.run is not None:
            self.run.cancel()

    def follow(self) -> None:
        """Poll an identification in another process; read its estimate once written."""
        if self.followed is None or self.is_fitting or self.reading is not None:
            return
        self.followed.poll()
        if self.followed.has_written(ESTIMATE_NAME):
            path, campaign = self.followed.path.with_name(ESTIMATE_NAME), self.source.campaign
            self.reading = FitRun(lambda listener: read_estimated(path, campaign))
            self.reading.start()

    def adopt_result(self) -> bool:
        """Adopt the estimate of a fit that has ended since the last call, and set the knobs to it."""
        for run in (self.run, self.reading):
            if run is not None and run.state is RunState.FINISHED and run.result is not None:
                self._adopt_estimate(run.result)
                if self.shown_run is not None:
                    self.shown_run.reports.append(_end_of(run.result))
                # Adopted once: the next call must not set the knobs again.
                run.result = None
                return True
        return False

    def _adopt_estimate(self, estimate: Estimate) -> None:
        self.estimate = estimate
        mechanism = estimate.mechanism_among(self.campaign.mechanism, self.source.campaign.mechanism)
        is_other = mechanism is not self.campaign.mechanism
        self.campaign = replace(self.campaign, mechanism=mechanism, records=self._interpret_records(estimate))
        self.scenes = scenes_of(self.campaign)
        # Cached pictures belong to the earlier estimate.
        self._compared.clear()
        if is_other:
            self._steps.clear()
            self.state = self.state.with_knobs_of(self.campaign)
            self.hand = self.hand if self.hand in self.state.knobs else next(iter(self.state.knobs))
        self.to_estimate()

    def _interpret_records(self, estimate: Estimate) -> tuple[CampaignRecord, ...]:
        """Interpret the records as a fit did, keeping their parameters.

        Their use is that of the file, so that the next fit includes records that this one left out.
        """
        own = {r.name: r for r in estimate.records}

        def at_start(q: Parameter) -> Parameter:
            return replace(q, value=estimate.values.get(q.name, q.value)) if is_of_start(q) else q

        return tuple(
            replace(own.get(r.name, r), parameters=tuple(map(at_start, r.parameters)), use=r.use)
            for r in self.campaign.records
        )
