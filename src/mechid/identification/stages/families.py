"""Families of effects that a mechanism or its records may have, as models of one problem."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, islice

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.campaign.identify_options import MAINS
from mechid.identification.effects.augmented import AugmentedModel, augment
from mechid.identification.effects.campaign_disturbances import possible
from mechid.identification.effects.disturbance import Disturbance, lacking_tables
from mechid.identification.effects.effect import AddedTerms, lay_out, substitute_law
from mechid.identification.effects.mains import mains
from mechid.identification.output_error.problem import Problem
from mechid.identification.search.rest import commanded_rest_window
from mechid.identification.stages.settings import STAGES
from mechid.plant import friction_position
from mechid.plant.block import Extension
from mechid.plant.law import Law
from mechid.plant.plant import Plant
from mechid.plant.superset import Superset, rivals_of, superset_of, unlisted_extensions, with_tables
from mechid.signal.settings import HUM

GAIN_TABLE = "transducer"
"""The table that holds the gain of the test stand: a record may have one of its own only where it is there."""
RATIO = "gear.ratio"
SLOW = (friction_position.ROTOR.table, friction_position.OUTPUT.table)
"""Lists of terms that vary so slowly with the angle that the first moments do not tell their number of periods."""
OF_RECORDS = ("record.delay", "record.voltage", "record.gain", "clock")
"""Disturbances that are free from the first moments on; a clock, or a temperature, of one record is seen later."""


@dataclass(frozen=True)
class Family:
    """Effects that are freed together.

    Attributes
    ----------
    name : str
    records : bool
        Delay, supply, gain, clock and hum of single records.
    terms : bool
        Terms of the mechanism that are looked for where a file lacks one.
    rarer : bool
        With them those that are rarer.
    """

    name: str
    records: bool = False
    terms: bool = False
    rarer: bool = False


RECORDS = Family("values of single records", records=True)
TERMS = Family("terms", terms=True)
ALL_TERMS = Family("terms, rarer ones too", terms=True, rarer=True)
TERMS_AND_RECORDS = Family("terms and values of single records", records=True, terms=True)
EVERYTHING = Family("all terms and values of single records", records=True, terms=True, rarer=True)


@dataclass(frozen=True, eq=False)
class Families:
    """What a campaign's mechanism and records may have beside what is written.

    Attributes
    ----------
    plain : Problem
        Of the mechanism as written.
    campaign : Campaign
    law : Law or None
        That stands in place of the mechanism's own one in all models.
    """

    plain: Problem
    campaign: Campaign
    law: Law | None = None

    @property
    def allows_terms(self) -> bool:
        """Whether terms and laws may be added."""
        return self.campaign.options.terms

    @cached_property
    def base(self) -> AddedTerms:
        """The mechanism as written, or with the law."""
        mechanism = self.plain.space.mechanism
        return substitute_law(mechanism, self.law) if self.law else AddedTerms(mechanism)

    @cached_property
    def bare(self) -> AugmentedModel:
        """The model with nothing beside."""
        return augment(self.plain, self.base, None, (), (), self.law.name if self.law else "as written")

    @cached_property
    def superset(self) -> Superset | None:
        """All terms that may be free from the first moments on."""
        return self._superset(())

    @cached_property
    def unlisted(self) -> Mapping[str, Extension]:
        """Terms of any other whole number of periods in a turn, by name."""
        return unlisted_extensions(self.base.mechanism)

    def is_slow(self, name: str) -> bool:
        """Tell whether an effect is a term whose number of periods the first moments do not tell."""
        return name in self.unlisted and self.unlisted[name].table in SLOW

    def periods(self, name: str) -> int:
        """Return the number of periods in a turn of an unlisted term."""
        return _periods(self.unlisted[name])

    def counterpart(self, name: str) -> str | None:
        """Return the friction over the output's angle that goes by about as fast as one over the rotor's, or the other.

        None where there is none.
        """
        ratio = self.plain.space.mechanism.parameters.get(RATIO)
        if not self.is_slow(name) or ratio is None:
            return None
        of_rotor = self.unlisted[name].table == SLOW[0]
        periods = self.periods(name) * abs(ratio.value) ** (1 if of_rotor else -1)
        return self.by_periods.get(SLOW[1] if of_rotor else SLOW[0], {}).get(round(periods))

    def with_periods(self, name: str, periods: int) -> str | None:
        """Return the name of the unlisted term of another's list with a number of periods; None where there is none."""
        return self.by_periods[self.unlisted[name].table].get(periods)

    @cached_property
    def by_periods(self) -> dict[str, dict[int, str]]:
        """Names of the unlisted terms by their list and number of periods in a turn."""
        found: dict[str, dict[int, str]] = {}
        for name, one in self.unlisted.items():
            found.setdefault(one.table, {})[_periods(one)] = name
        return found

    def _superset(self, names: Sequence[str]) -> Superset | None:
        """Return the superset with some of the unlisted terms too: the same plant whichever they are."""
        key = tuple(names)
        if key not in self._supersets:
            self._supersets[key] = self._superset_with(key)
        return self._supersets[key]

    @cached_property
    def _supersets(self) -> dict[tuple[str, ...], Superset | None]:
        return {}

    def _superset_with(self, names: tuple[str, ...]) -> Superset | None:
        layout = self.base.mechanism.plant.layout
        if layout is None:
            return None
        further = [self.unlisted[name] for name in self._places(names)] if self.allows_terms else []
        return superset_of(self.base.mechanism, grown_only=True, further=further, tables=self._tables)

    @property
    def _tables(self) -> tuple[str, ...]:
        """Tables that values of single records may need."""
        layout = self.base.mechanism.plant.layout
        return (GAIN_TABLE,) if layout is not None and layout.flying is None else ()

    @property
    def record_layout(self) -> Plant:
        """The plant of models that have values of single records beside the mechanism, and no term."""
        return with_tables(self.base.mechanism, self._tables).plant

    def _places(self, names: Sequence[str]) -> Iterator[str]:
        """Yield an unlisted term for each place that the plant has: those named, then others at their null value.

        There are places for slow ones only where one is named: 4 % of the time of all steps else.
        """
        for table, own in self.by_periods.items():
            chosen = [name for name in names if self.unlisted[name].table == table]
            others = (name for name in own.values() if name not in chosen)
            if chosen or table not in SLOW:
                yield from islice(chain(chosen, others), places_of(table))

    @cached_property
    def _of_records(self) -> tuple[Disturbance, ...]:
        bare = augment(self.plain, self.base, self.superset, (), (), "").problem
        rests = {t.name: commanded_rest_window(t) for t in self.plain.targets}
        return tuple(
            one for one in possible(bare, self.campaign, rests=rests) if one.name in OF_RECORDS or one.lines_hz
        )

    @property
    def seen_lines(self) -> tuple[str, ...]:
        """Names of disturbances that have lines alone, as hum that the records show."""
        return tuple(one.name for one in self._of_records if one.lines_hz and not one.parameters)

    def model(
        self, family: Family, base: AugmentedModel | None = None, near: FloatArray | None = None
    ) -> AugmentedModel:
        """Return the model of a family.

        Parameters
        ----------
        family : Family
        base : AugmentedModel or None
            Of which it has the effects in any case.
        near : (n,) or None
            Where the mechanism as written leaves what hum is looked for in; None looks in the records.
        """
        own = self._of_records if family.records else ()
        if family.records and near is not None:
            seen = (one for one in possible(self.plain, self.campaign, near) if one.lines_hz)
            own = (*(one for one in own if not one.lines_hz), *seen)
        listed = self.superset.terms if self.superset and family.terms and self.allows_terms else ()
        names = [t.name for t in listed if t.name not in self.unlisted and (family.rarer or not t.rarer)]
        return self.with_effects(base, names, own, family.name)

    @cached_property
    def unseen_grids(self) -> tuple[float, ...]:
        """Nominal frequencies of the grid, Hz, whose hum the records may hide; none where it is seen or excluded."""
        allowed = self.campaign.options.disturbances
        if any(one.lines_hz for one in self._of_records) or not (allowed == "auto" or MAINS in allowed):
            return ()
        return () if any(t.leading.turns for t in self.plain.targets) else HUM.mains_hz

    def with_hum(
        self, base: AugmentedModel, grid_hz: float, q: FloatArray, horizons: Mapping[str, int]
    ) -> AugmentedModel | None:
        """Return a model with hum too, at the frequency that what is followed of the records tells.

        It has the coordinates of the other, since hum is projected out, and no place for further terms.

        None where too little is followed of any record.

        Parameters
        ----------
        base : AugmentedModel
            Laid out, or with nothing beside.
        grid_hz : float
            Nominal frequency, which holds where they do not tell it.
        q : (n,)
            Of that model.
        horizons : mapping of record to int
            Samples that it follows there.
        """
        problem = base.problem
        followed = replace(problem, targets=tuple(t.truncate(horizons[t.name]) for t in problem.targets))
        hum = mains(followed, q, grid_hz)
        if hum is None:
            return None
        name = f"{base.name}, {hum.name}" if base.effects else hum.name
        return replace(base, name=name, disturbances=(*base.disturbances, hum)).laid_out(self.plain)

    def with_effect(self, base: AugmentedModel, name: str) -> AugmentedModel:
        """Return a model with one more effect, a term or a disturbance, by its name."""
        one = next((one for one in self._of_records if one.name == name), None)
        words = f"{base.name}, {name}" if base.effects else name
        return self.with_effects(base, () if one else (name,), (one,) if one else (), words)

    def with_other_term(self, base: AugmentedModel, old: str, new: str) -> tuple[AugmentedModel, dict[str, str]]:
        """Return a model with another term in place of one, and the names of that one's parameters in it."""
        less = base.keeping(self.plain, set(base.effects) - {old}, base.name)
        other = self.with_effects(less, (new,), (), base.name.replace(old, new))
        before, after = base.added.names_by_term[old], other.added.names_by_term[new]
        return other, dict(zip(before, after, strict=True))

    def with_effects(
        self, base: AugmentedModel | None, terms: Sequence[str], own: Sequence[Disturbance], name: str
    ) -> AugmentedModel:
        """Return the model with some more terms and disturbances beside another one, or beside none."""
        before = base or self.bare
        names = dict.fromkeys((*before.added.terms, *terms))
        there = {one.name for one in before.disturbances}
        disturbances = (*before.disturbances, *(one for one in own if one.name not in there))
        if not names:  # no place for terms, and one kernel whichever values of records are free
            model = replace(self.bare, name=name, disturbances=disturbances).laid_out(self.plain, self._tables)
            lanes = self.plain.coordinates.lanes + len(OF_RECORDS)
            return replace(model, problem=replace(model.problem, capacity=lanes))
        return augment(
            self.plain,
            self.base,
            self._superset([n for n in names if n in self.unlisted]),
            [*names],
            disturbances,
            name,
        )

    def laws(self) -> Iterator[Law]:
        """Yield the laws that may stand in place of the mechanism's."""
        if self.allows_terms:
            yield from rivals_of(self.plain.space.mechanism, grown_only=True)

    def with_law(self, law: Law) -> Families:
        """Return the families with a law in place of the mechanism's own one."""
        return replace(self, law=law)

    def by_law(self, law: Law, base: AugmentedModel | None = None) -> AugmentedModel:
        """Return the model with a law in place of the mechanism's own one, and with the effects of another model."""
        other = self.with_law(law)
        if base is None or not base.effects:
            return other.bare
        tables = lacking_tables(other.base.mechanism, base.disturbances)
        added = lay_out(other.base, base.added.terms, tables)
        problem = added.problem(self.plain, base.disturbances)
        return AugmentedModel(f"{base.name}, {law.name}", problem, added, base.disturbances, None, other.base)


def _periods(extension: Extension) -> int:
    shape = extension.structure
    return int(shape["order"]) if "order" in shape else round(360.0 / float(shape["period_deg"]))


def places_of(table: str) -> int:
    """Return how many unlisted terms of a list one plant has places for."""
    return STAGES.slow_at_once if table in SLOW else STAGES.unlisted_at_once
