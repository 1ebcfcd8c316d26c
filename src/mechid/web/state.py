"""State of one tab: the knobs' values, which of them a fit may move, and the way back."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from mechid.campaign import Campaign
from mechid.errors import UsageError, did_you_mean
from mechid.parameter import Parameter
from mechid.web.knobs import Knob, knobs, mechanism_at, turned_to

MOST_UNDONE = 200


@dataclass(frozen=True)
class Setting:
    """The values of all knobs by dotted name, and the names of those that a fit may move."""

    values: Mapping[str, float]
    free: frozenset[str]


@dataclass(frozen=True)
class State:
    """The present setting and those before it, the latest last.

    `grip` tells turns of one and the same grip at a knob, which are undone together; `above` holds for each knob that
    never lies below another one the name of that.
    """

    knobs: Mapping[str, Knob]
    now: Setting
    past: tuple[Setting, ...] = ()
    grip: str = field(default="")
    above: Mapping[str, str] = field(default_factory=dict)

    def turned(self, name: str, value: float, grip: str = "", *, along: Collection[str] = ()) -> State:
        """Return the state with a knob at another value, within its ends, and those that go along with it.

        Where one never lies below another, as static friction above Coulomb friction, one takes the other with it.

        Raises
        ------
        UsageError
            There is no such knob, or the value is no number.
        """
        knob = self._knob(name)
        if not value - value == 0.0:
            raise UsageError(f"{name}: {value} is no number to set it to")
        values = {**self.now.values, name: knob.within(value)}
        for upper, lower in self.above.items():
            if name in (upper, lower) and {upper, lower} <= values.keys() and values[upper] < values[lower]:
                other = upper if name == lower else lower
                values[other] = self.knobs[other].within(values[name])
                values[name] = min(values[name], values[upper]) if name == lower else max(values[name], values[lower])
        values |= {other: self.knobs[other].within(values[name]) for other in along}
        return self._at(Setting(values, self.now.free), grip)

    def with_free(self, name: str, *, is_free: bool) -> State:
        """Return the state with a knob given to the fit, or held."""
        self._knob(name)
        free = self.now.free | {name} if is_free else self.now.free - {name}
        return self._at(Setting(self.now.values, free))

    def at(self, values: Mapping[str, float], *, free: frozenset[str] | None = None) -> State:
        """Return the state at other values of some knobs, other ones free; names that are no knobs are passed over."""
        known = {name: self.knobs[name].within(v) for name, v in values.items() if name in self.knobs}
        given = self.now.free if free is None else free & self.knobs.keys()
        return self._at(Setting({**self.now.values, **known}, given))

    def undone(self) -> State:
        """Return the state before the last change; the first one stays."""
        if not self.past:
            return self
        return replace(self, now=self.past[-1], past=self.past[:-1], grip="")

    def with_knobs_of(self, campaign: Campaign) -> State:
        """Return the state of a campaign whose mechanism has other parameters, those in both as they are set here.

        Nothing before is undone: a setting of another mechanism would be half of one of this.
        """
        begun, was = first_state(campaign), self.now
        return replace(begun.at(was.values, free=was.free | (begun.now.free - was.values.keys())), past=())

    def _at(self, setting: Setting, grip: str = "") -> State:
        if setting == self.now:
            return self
        goes_on = grip and grip == self.grip
        past = self.past if goes_on else (*self.past, self.now)[-MOST_UNDONE:]
        return replace(self, now=setting, past=past, grip=grip)

    def _knob(self, name: str) -> Knob:
        if name not in self.knobs:
            raise UsageError(f"no parameter {name} to turn{did_you_mean(name, self.knobs)}")
        return self.knobs[name]


def first_state(campaign: Campaign) -> State:
    """Return the state of the campaign's files."""
    turned = knobs(campaign)
    free = frozenset(q.name for q in campaign.free)
    setting = Setting({name: knob.parameter.value for name, knob in turned.items()}, free)
    return State(turned, setting, above=campaign.mechanism.plant.related_parameters("above"))


def campaign_at(campaign: Campaign, state: State) -> Campaign:
    """Return a campaign at the values of a state, free to move where it says so."""
    values, free, turned = state.now.values, state.now.free, state.knobs

    def own(q: Parameter) -> Parameter:
        return turned_to(q, values[q.name], turned[q.name], is_free=q.name in free) if q.name in turned else q

    records = tuple(replace(r, parameters=tuple(map(own, r.parameters))) for r in campaign.records)
    return replace(campaign, mechanism=mechanism_at(campaign.mechanism, values, free, turned), records=records)
