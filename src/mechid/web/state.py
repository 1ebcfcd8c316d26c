"""State of one tab: values of the knobs, free parameters, and undo history."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from mechid.campaign import Campaign
from mechid.errors import UsageError, did_you_mean
from mechid.parameter import Parameter
from mechid.web.knobs import Knob, knobs, mechanism_at, set_parameter

MOST_UNDONE = 200


@dataclass(frozen=True)
class Setting:
    """Values of all knobs by dotted name, and names of the free ones."""

    values: Mapping[str, float]
    free: frozenset[str]


@dataclass(frozen=True)
class State:
    """Current setting and earlier ones, the latest last.

    `grip` identifies one continuous movement of a knob, which is undone as a whole. `above` maps knobs to others that
    they must not fall below.
    """

    knobs: Mapping[str, Knob]
    now: Setting
    past: tuple[Setting, ...] = ()
    grip: str = field(default="")
    above: Mapping[str, str] = field(default_factory=dict)

    def set_value(self, name: str, value: float, grip: str = "", *, along: Collection[str] = ()) -> State:
        """Set a knob to a value within its ends, together with the knobs `along`.

        If a knob must not fall below another, as static friction below Coulomb friction, the other one moves too.

        Raises
        ------
        UsageError
            There is no such knob, or the value is not a finite number.
        """
        knob = self._knob(name)
        # False for NaN and for both infinities.
        if not value - value == 0.0:
            raise UsageError(f"{name}: {value} is no number to set it to")
        values = {**self.now.values, name: knob.clip(value)}
        for upper, lower in self.above.items():
            if name in (upper, lower) and {upper, lower} <= values.keys() and values[upper] < values[lower]:
                other = upper if name == lower else lower
                values[other] = self.knobs[other].clip(values[name])
                # The other knob may have stopped at its own end, which then limits this one too.
                values[name] = min(values[name], values[upper]) if name == lower else max(values[name], values[lower])
        values |= {other: self.knobs[other].clip(values[name]) for other in along}
        return self._at(Setting(values, self.now.free), grip)

    def with_free(self, name: str, *, is_free: bool) -> State:
        """Set whether a fit may change a knob."""
        self._knob(name)
        free = self.now.free | {name} if is_free else self.now.free - {name}
        return self._at(Setting(self.now.values, free))

    def at(self, values: Mapping[str, float], *, free: frozenset[str] | None = None) -> State:
        """Set several knobs, and optionally the free ones; unknown names are ignored."""
        known = {name: self.knobs[name].clip(v) for name, v in values.items() if name in self.knobs}
        given = self.now.free if free is None else free & self.knobs.keys()
        return self._at(Setting({**self.now.values, **known}, given))

    def undo(self) -> State:
        """Return the state before the last change, or this one if there is none."""
        if not self.past:
            return self
        return replace(self, now=self.past[-1], past=self.past[:-1], grip="")

    def with_knobs_of(self, campaign: Campaign) -> State:
        """Return the state for a campaign with another mechanism, keeping the values of common knobs."""
        # The history is dropped, since settings of another mechanism would be incomplete.
        first, was = first_state(campaign), self.now
        return replace(first.at(was.values, free=was.free | (first.now.free - was.values.keys())), past=())

    def _at(self, setting: Setting, grip: str = "") -> State:
        if setting == self.now:
            return self
        # One movement of a knob sends many values, which are undone together.
        goes_on = grip and grip == self.grip
        past = self.past if goes_on else (*self.past, self.now)[-MOST_UNDONE:]
        return replace(self, now=setting, past=past, grip=grip)

    def _knob(self, name: str) -> Knob:
        if name not in self.knobs:
            raise UsageError(f"no parameter {name} to turn{did_you_mean(name, self.knobs)}")
        return self.knobs[name]


def first_state(campaign: Campaign) -> State:
    """Return the state with the values of the campaign files."""
    turned = knobs(campaign)
    free = frozenset(q.name for q in campaign.free)
    setting = Setting({name: knob.parameter.value for name, knob in turned.items()}, free)
    return State(turned, setting, above=campaign.mechanism.plant.related_parameters("above"))


def campaign_at(campaign: Campaign, state: State) -> Campaign:
    """Return the campaign at the values and free parameters of a state."""
    values, free, turned = state.now.values, state.now.free, state.knobs

    def turn(q: Parameter) -> Parameter:
        return set_parameter(q, values[q.name], turned[q.name], is_free=q.name in free) if q.name in turned else q

    records = tuple(replace(r, parameters=tuple(map(turn, r.parameters))) for r in campaign.records)
    return replace(campaign, mechanism=mechanism_at(campaign.mechanism, values, free, turned), records=records)
