"""One tab: what it has set, what it looks at, and the fit it has running. Knows no browser."""

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
from mechid.web.diagnosed import Diagnosed
from mechid.web.estimate import Estimate, estimate_of, read_estimated
from mechid.web.fit_run import FitRun, RunState
from mechid.web.followed_run import FollowedRun
from mechid.web.named_effect import NamedEffect
from mechid.web.picture import Effect, Picture, Scene, Stretch, scenes_of
from mechid.web.state import State, campaign_at, first_state
from mechid.web.sweep import SweepPicture, sweep_picture

MOST_SHOWN = 4
"""Records side by side."""
FIRST_LOOK_S = 1.0


@dataclass(frozen=True, eq=False)
class Source:
    """What all tabs begin from: a campaign whose files are read, and a finished fit of it where there is one.

    `journal` is that of an identification into the result folder, which may be at work; `workers` are threads of a
    fit. `diagnosed` is what is said of a campaign whose mechanism is the
    one that a diagnosis proposes: the page begins at its values, and each effect has a switch.
    """

    campaign: Campaign
    estimate: Estimate | None = None
    workers: int | None = None
    journal: Path | None = None
    diagnosed: Diagnosed | None = None

    @property
    def effects(self) -> tuple[NamedEffect, ...]:
        """Those that a diagnosis names."""
        return self.diagnosed.effects if self.diagnosed else ()

    @cached_property
    def scenes(self) -> dict[str, Scene]:
        """What can be looked at, by label; tabs share it until a fit takes a record otherwise."""
        return scenes_of(self.campaign)


def _end_of(estimate: Estimate) -> Progress:
    """Return the last report of a fit that has ended: how far off the records are at its estimate."""
    return Progress(1, 1, "verdict", "all records compared with their noise", None, 0.0, over_noise=estimate.over_noise)


class Session:
    """One tab.

    Parameters
    ----------
    source : Source

    Attributes
    ----------
    state : State
    estimate : Estimate or None
        The last one: of the files, then of this tab's own fits.
    shown : tuple of str
        Records that are looked at.
    seconds : float
        Of each, from its start.
    hand : str
        The knob last touched.
    compares : bool
        Whether the estimate's curves are drawn too.
    run : FitRun or None
        The fit at work, or the last one.
    """

    def __init__(self, source: Source) -> None:
        self.source, self.campaign = source, source.campaign
        self.estimate = source.estimate
        self.state: State = first_state(self.campaign)
        if self.estimate and not source.effects:
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

    # What the page asks for.

    def turn(self, name: str, value: float, grip: str = "") -> None:
        """Turn a knob; it is in hand then."""
        off = (one for one in self.source.effects if not one.is_on(self.state.now.values))
        along = [own for one in off for own, followed in one.follows.items() if followed == name]
        self.state = self.state.turned(name, value, grip, along=along)
        self.hand = name

    def switch(self, name: str, *, is_on: bool) -> None:
        """Set an effect to the values found, or to where there is nothing of it and no fit moves it."""
        effect = self.source.diagnosed.effect(name) if self.source.diagnosed else None
        if effect is None or effect.why_fixed:
            raise UsageError(f"no effect {name} to switch")
        self.state = self._at(effect.found if is_on else effect.nulls_at(self.state.now.values))
        self.hand = next(iter(effect.nulls))

    def take(self, name: str) -> None:
        """Take a knob in hand without turning it."""
        if name not in self.state.knobs:
            raise UsageError(f"no parameter {name} to take in hand")
        self.hand = name

    def set_free(self, name: str, *, is_free: bool) -> None:
        """Give a knob to the fit, or hold it."""
        self.state = self.state.with_free(name, is_free=is_free)

    def undo(self) -> None:
        """Take the last change back."""
        self.state = self.state.undone()

    def to_estimate(self) -> None:
        """Set all knobs to the last estimate; effects that it has not are off."""
        if self.estimate and self.reaches_estimate:
            self.state = self._at(self.values_of(self.estimate))

    def to_file(self) -> None:
        """Set all knobs to the values of the mechanism file; added terms to where the fit that added them began."""
        files = (self.campaign, self.source.campaign)
        self.state = self._at({q.name: q.value for campaign in files for q in campaign.parameters.values()})

    @property
    def reaches_estimate(self) -> bool:
        """Whether the mechanism can be that of the last estimate: a law that no null leads to has to be in that too."""
        if self.estimate is None:
            return False
        fixed = (one for one in self.source.effects if not one.nulls and not one.is_of_records)
        return all(one.found.keys() <= self.estimate.values.keys() for one in fixed)

    def values_of(self, estimate: Estimate) -> dict[str, float]:
        """Return the values of an estimate, and where there is nothing of the effects that it has not."""
        there = {**self.state.now.values, **estimate.values}
        return {name: v for one in self.source.effects for name, v in one.nulls_at(there).items()} | dict(
            estimate.values
        )

    def _at(self, values: Mapping[str, float]) -> State:
        """Return the state at some values: a fit does not move an effect that is off, and one switched on it may."""
        was, moved = self.state.now.values, self.state.at(values)
        free = self.state.now.free
        for effect in self.source.effects:
            before, after = effect.is_on(was), effect.is_on(moved.now.values)
            if before != after:
                free = free | effect.free if after else free - effect.found.keys()
        return self.state.at(values, free=free)

    def look(self, names: tuple[str, ...], seconds: float) -> None:
        """Show some records, the first `seconds` of each."""
        unknown = [name for name in names if name not in self.scenes]
        if unknown:
            raise UsageError(f"no record {unknown[0]} to show")
        if not seconds > 0.0:
            raise UsageError(f"{seconds} s is no stretch of a record")
        self.shown, self.seconds = names[-MOST_SHOWN:], seconds

    def compare(self, *, is_on: bool) -> None:
        """Draw the estimate's curves too, or no longer."""
        self.compares = is_on

    # What the page shows.

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism as it is set."""
        return campaign_at(self.campaign, self.state).mechanism

    def pictures(self) -> dict[str, Picture]:
        """Return the shown records beside the model as it is set."""
        return {name: self._picture(name, self.state) for name in self.shown}

    def compared(self) -> dict[str, Picture]:
        """Return the shown records beside the model at the estimate."""
        if not self.estimate or not self.reaches_estimate:
            return {}
        at = self.state.at(self.values_of(self.estimate))
        for name in self.shown:
            if (name, self.seconds) not in self._compared:
                self._compared[name, self.seconds] = self._picture(name, at)
        return {name: self._compared[name, self.seconds] for name in self.shown}

    def effects(self) -> dict[str, Effect]:
        """Return what a small step of the knob in hand does to the shown records."""
        mechanism, knob = self.mechanism, self.state.knobs[self.hand]
        return {name: self.scenes[name].effect(mechanism, knob, self._stretch(name, self.state)) for name in self.shown}

    def sweeps(self, pictures: Mapping[str, Picture]) -> dict[str, SweepPicture]:
        """Return the pictures of records whose step rate varies over time and frequency."""
        mechanism, scenes = self.mechanism, self.scenes
        return {
            name: sweep_picture(scenes[name], p, mechanism) for name, p in pictures.items() if scenes[name].is_sweep
        }

    def _picture(self, name: str, state: State) -> Picture:
        mechanism = campaign_at(self.campaign, state).mechanism
        return self.scenes[name].picture(mechanism, self._stretch(name, state))

    def _stretch(self, name: str, state: State) -> Stretch:
        """Return what of a record is simulated."""
        own = {q.name: state.now.values.get(q.name, q.value) for q in self.scenes[name].record.parameters}
        if name not in self._steps:
            self._steps[name] = self.scenes[name].steps_needed(self.mechanism)
        return Stretch(self.seconds, own, self._steps[name])

    def mechanism_file(self) -> str:
        """Return the text of a mechanism.toml with the values, and the free parameters, as they are set.

        An effect that is off does not stand in it.
        """
        said, mechanism = self.source.diagnosed, self.mechanism
        return mechanism_text(
            said.without_off(mechanism, self.state.now.values) if said else mechanism,
            f"set by hand with mechid explore, from {self.campaign.mechanism_path.name}",
        )

    # The fit.

    @property
    def is_fitting(self) -> bool:
        """Whether a fit is at work."""
        return self.run is not None and self.run.state is RunState.RUNNING

    @property
    def watched(self) -> FitRun | FollowedRun | None:
        """The run that is shown: this tab's own, or one elsewhere that was at work while the tab was open."""
        return self.run or (self.followed if self.followed and self.followed.is_alive else None)

    @property
    def is_at_catalogue(self) -> bool:
        """Whether what is free stands where the file has it, and no estimate: a fit from there seldom succeeds."""
        if self.source.effects:
            return False  # the file proposed holds values that were found
        now = self.state.now
        begun = {q.name: q.value for q in self.source.campaign.parameters.values()}
        estimated = self.estimate.values if self.estimate else {}
        return all(now.values[name] == begun.get(name) for name in now.free) and not all(
            now.values[name] == estimated.get(name) for name in now.free
        )

    def fit_from_here(self) -> None:
        """Begin a fit of what is free from the knobs' values."""
        values, n = dict(self.state.now.values), self.source.workers
        self._begin(lambda campaign, listener: identify_from(campaign, values, workers=n, listener=listener))

    def search(self) -> None:
        """Begin an identification with its own search for a start, as ``mechid identify`` does."""
        self._begin(lambda campaign, listener: identify(campaign, workers=self.source.workers, listener=listener))

    def _begin(self, work: Callable[[Campaign, Listener], Fit]) -> None:
        if self.is_fitting:
            raise UsageError("a fit is at work; cancel it first")
        campaign = self._without_off(campaign_at(self.campaign, self.state))

        def fit_and_judge(listener: Listener) -> Estimate:
            fit = work(campaign, listener)
            listener(Progress(1, 1, "verdict", "all records are simulated and compared with their noise", None, 0.0))
            return estimate_of(fit, campaign, "the last fit of this tab")

        self.run = FitRun(fit_and_judge)
        self.run.start()

    def _without_off(self, campaign: Campaign) -> Campaign:
        """Return a campaign whose records have the mechanism's values in place of those of effects that are off."""
        off = {n for one in self.source.effects if not one.is_on(self.state.now.values) for n in one.follows}
        records = campaign.records
        kept = (replace(r, parameters=tuple(q for q in r.parameters if q.name not in off)) for r in records)
        return replace(campaign, records=tuple(kept)) if off else campaign

    def cancel(self) -> None:
        """Stop the fit at work; everything else stays as it is."""
        if self.run is not None:
            self.run.cancel()

    def follow(self) -> None:
        """See how an identification elsewhere goes on; when it has left its estimate, read that."""
        if self.followed is None or self.is_fitting or self.reading is not None:
            return
        self.followed.poll()
        if self.followed.has_left(ESTIMATE_NAME):
            path, campaign = self.followed.path.with_name(ESTIMATE_NAME), self.source.campaign
            self.reading = FitRun(lambda listener: read_estimated(path, campaign))
            self.reading.start()

    def take_up(self) -> bool:
        """Take up the estimate of a fit that has ended since the last call, and set the knobs to it."""
        for run in (self.run, self.reading):
            if run is not None and run.state is RunState.FINISHED and run.result is not None:
                self._take_estimate(run.result)
                if self.watched is not None:
                    self.watched.reports.append(_end_of(run.result))
                run.result = None
                return True
        return False

    def _take_estimate(self, estimate: Estimate) -> None:
        self.estimate = estimate
        mechanism = estimate.mechanism_among(self.campaign.mechanism, self.source.campaign.mechanism)
        is_other = mechanism is not self.campaign.mechanism
        self.campaign = replace(self.campaign, mechanism=mechanism, records=self._as_taken(estimate))
        self.scenes = scenes_of(self.campaign)
        self._compared.clear()
        if is_other:
            self._steps.clear()
            self.state = self.state.with_knobs_of(self.campaign)
            self.hand = self.hand if self.hand in self.state.knobs else next(iter(self.state.knobs))
        self.to_estimate()

    def _as_taken(self, estimate: Estimate) -> tuple[CampaignRecord, ...]:
        """Return the records with the sign and command that a fit took them to have, and their own knobs.

        Their use stays the file's: a record that one fit left out is one to estimate from for the next.
        """
        own = {r.name: r for r in estimate.records}

        def begun(q: Parameter) -> Parameter:
            return replace(q, value=estimate.values.get(q.name, q.value)) if is_of_start(q) else q

        return tuple(
            replace(own.get(r.name, r), parameters=tuple(map(begun, r.parameters)), use=r.use)
            for r in self.campaign.records
        )
