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
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import MAINS_PREFIX, Disturbance, missing_tables
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
"""Table of the test stand's gain; a record can have its own gain only if the table is present."""
RATIO = "gear.ratio"
SLOW = (friction_position.ROTOR.table, friction_position.OUTPUT.table)
"""Lists of terms that vary so slowly with the angle that the first moments do not determine their number of periods."""
FREE_FROM_START = ("record.delay", "record.voltage", "record.gain", "clock")
"""Disturbances that are free from the first moments on; a clock or a temperature of one record becomes visible later.
"""


@dataclass(frozen=True)
class Family:
    """Effects that are freed together.

    Attributes
    ----------
    name : str
    records : bool
        Delay, supply, gain, clock and hum of single records.
    terms : bool
        Terms of the mechanism that a file may lack.
    rarer : bool
        Includes rarer terms.
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
    """Effects that a campaign's mechanism and records may have in addition to the file.

    Attributes
    ----------
    plain : Problem
        Problem of the mechanism as written.
    campaign : Campaign
    law : Law or None
        Law that replaces the mechanism's own one in all models.
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
        """Mechanism as written, or with the law."""
        mechanism = self.plain.space.mechanism
        return substitute_law(mechanism, self.law) if self.law else AddedTerms(mechanism)

    @cached_property
    def bare(self) -> AugmentedModel:
        """Model without effects."""
        return augment(self.plain, self.base, None, (), (), self.law.name if self.law else "as written")

    @cached_property
    def superset(self) -> Superset | None:
        """All terms that may be free from the first moments on."""
        return self._superset(())

    @cached_property
    def unlisted_terms(self) -> Mapping[str, Extension]:
        """Terms of any other whole number of periods in a turn, by name."""
        return unlisted_extensions(self.base.mechanism)

    def is_slow(self, name: str) -> bool:
        """Tell whether an effect is a term whose number of periods the first moments do not determine."""
        return name in self.unlisted_terms and self.unlisted_terms[name].table in SLOW

    def periods(self, name: str) -> int:
        """Return the number of periods in a turn of an unlisted term."""
        return _periods(self.unlisted_terms[name])

    def counterpart(self, name: str) -> str | None:
        """Return the other body's term of friction over the angle that has about the same period.

        The bodies are rotor and output. None if there is no such term.
        """
        ratio = self.plain.space.mechanism.parameters.get(RATIO)
        if not self.is_slow(name) or ratio is None:
            return None
        of_rotor = self.unlisted_terms[name].table == SLOW[0]
        periods = self.periods(name) * abs(ratio.value) ** (1 if of_rotor else -1)
        return self.by_periods.get(SLOW[1] if of_rotor else SLOW[0], {}).get(round(periods))

    def with_periods(self, name: str, periods: int) -> str | None:
        """Return the name of the unlisted term of the same list with a number of periods; None if there is none."""
        return self.by_periods[self.unlisted_terms[name].table].get(periods)

    @cached_property
    def by_periods(self) -> dict[str, dict[int, str]]:
        """Names of the unlisted terms by their list and number of periods in a turn."""
        found: dict[str, dict[int, str]] = {}
        for name, one in self.unlisted_terms.items():
            found.setdefault(one.table, {})[_periods(one)] = name
        return found

    def _superset(self, names: Sequence[str]) -> Superset | None:
        """Return the superset including some of the unlisted terms.

        The plant is the same for any choice of terms.
        """
        key = tuple(names)
        if key not in self._supersets:
            self._supersets[key] = self._build_superset(key)
        return self._supersets[key]

    @cached_property
    def _supersets(self) -> dict[tuple[str, ...], Superset | None]:
        return {}

    def _build_superset(self, names: tuple[str, ...]) -> Superset | None:
        layout = self.base.mechanism.plant.layout
        if layout is None:
            return None
        further = [self.unlisted_terms[name] for name in self._place_terms(names)] if self.allows_terms else []
        return superset_of(self.base.mechanism, grown_only=True, further=further, tables=self.record_tables)

    @property
    def record_tables(self) -> tuple[str, ...]:
        """Tables that per-record values may need."""
        layout = self.base.mechanism.plant.layout
        return (GAIN_TABLE,) if layout is not None and layout.flying is None else ()

    @property
    def record_layout(self) -> Plant:
        """Plant of models that have per-record values and no additional term."""
        return with_tables(self.base.mechanism, self.record_tables).plant

    def _place_terms(self, names: Sequence[str]) -> Iterator[str]:
        """Yield an unlisted term for each place of the plant: the named ones, then others at their null value.

        There are places for slow terms only if one is named, because they take 4 % of the time of every step.
        """
        for table, own in self.by_periods.items():
            chosen = [name for name in names if self.unlisted_terms[name].table == table]
            others = (name for name in own.values() if name not in chosen)
            if chosen or table not in SLOW:
                yield from islice(chain(chosen, others), places_of(table))

    @cached_property
    def _record_disturbances(self) -> tuple[Disturbance, ...]:
        bare = augment(self.plain, self.base, self.superset, (), (), "").problem
        rests = {t.name: commanded_rest_window(t) for t in self.plain.targets}
        return tuple(
            one
            for one in possible_disturbances(bare, self.campaign, rests=rests)
            if one.name in FREE_FROM_START or one.lines_hz
        )

    @property
    def seen_lines(self) -> tuple[str, ...]:
        """Names of disturbances that consist of lines only, such as hum that the records show."""
        return tuple(one.name for one in self._record_disturbances if one.lines_hz and not one.parameters)

    def model(
        self, family: Family, base: AugmentedModel | None = None, near: FloatArray | None = None
    ) -> AugmentedModel:
        """Return the model of a family.

        Parameters
        ----------
        family : Family
        base : AugmentedModel or None
            Model whose effects are included in any case.
        near : (n,) or None
            Point whose residual is searched for hum; None searches the records.
        """
        own = self._record_disturbances if family.records else ()
        if family.records and near is not None:
            seen = (one for one in possible_disturbances(self.plain, self.campaign, near) if one.lines_hz)
            own = (*(one for one in own if not one.lines_hz), *seen)
        listed = self.superset.terms if self.superset and family.terms and self.allows_terms else ()
        names = [t.name for t in listed if t.name not in self.unlisted_terms and (family.rarer or not t.rarer)]
        return self.with_effects(base, names, own, family.name)

    @cached_property
    def unseen_grids(self) -> tuple[float, ...]:
        """Nominal grid frequencies, Hz, of hum that the records may hide; empty if hum is visible or excluded."""
        allowed = self.campaign.options.disturbances
        if any(one.lines_hz for one in self._record_disturbances) or not (allowed == "auto" or MAINS in allowed):
            return ()
        return () if any(t.leading.turns for t in self.plain.targets) else HUM.mains_hz

    @cached_property
    def seen_grids(self) -> tuple[float, ...]:
        """Nominal grid frequencies, Hz, of hum that the records show and the mechanism as written lacks."""
        if any(t.leading.turns for t in self.plain.targets):
            return ()
        names = [one.name for one in self._record_disturbances if one.lines_hz and one.name.startswith(MAINS_PREFIX)]
        return tuple(float(name.removeprefix(MAINS_PREFIX).removesuffix("Hz")) for name in names)

    def with_hum(
        self, base: AugmentedModel, grid_hz: float, q: FloatArray, horizons: Mapping[str, int]
    ) -> AugmentedModel | None:
        """Return a model with additional hum, at the frequency determined by the followed samples.

        It has the coordinates of the other model, since hum is projected out, and no place for further terms. None if
        too little is followed of any record.

        Parameters
        ----------
        base : AugmentedModel
            Laid out, or without effects.
        grid_hz : float
            Nominal frequency, used if the samples do not determine it.
        q : (n,)
            Point of that model.
        horizons : mapping of record to int
            Samples that it follows there.
        """
        problem = base.problem
        followed = replace(problem, targets=tuple(t.truncate(horizons[t.name]) for t in problem.targets))
        hum = mains(followed, q, grid_hz)
        if hum is None:
            return None
        name = f"{base.name}, {hum.name}" if base.effects else hum.name
        return replace(base, name=name, disturbances=(*base.disturbances, hum)).lay_out(self.plain)

    def with_effect(self, base: AugmentedModel, name: str) -> AugmentedModel:
        """Return a model with one more effect, a term or a disturbance, by name."""
        one = next((one for one in self._record_disturbances if one.name == name), None)
        words = f"{base.name}, {name}" if base.effects else name
        return self.with_effects(base, () if one else (name,), (one,) if one else (), words)

    def with_other_term(self, base: AugmentedModel, old: str, new: str) -> tuple[AugmentedModel, dict[str, str]]:
        """Return a model with one term replaced by another, and the new names of its parameters by the old ones."""
        less = base.keep_effects(self.plain, set(base.effects) - {old}, base.name)
        other = self.with_effects(less, (new,), (), base.name.replace(old, new))
        before, after = base.added.names_by_term[old], other.added.names_by_term[new]
        return other, dict(zip(before, after, strict=True))

    def with_effects(
        self, base: AugmentedModel | None, terms: Sequence[str], own: Sequence[Disturbance], name: str
    ) -> AugmentedModel:
        """Return the model with additional terms and disturbances, starting from another model or from the bare one."""
        before = base or self.bare
        names = dict.fromkeys((*before.added.terms, *terms))
        there = {one.name for one in before.disturbances}
        disturbances = (*before.disturbances, *(one for one in own if one.name not in there))
        # Without a place for terms, the plant stays small, and all choices of free record values share one kernel.
        if not names:
            model = replace(self.bare, name=name, disturbances=disturbances).lay_out(self.plain, self.record_tables)
            lanes = self.plain.coordinates.lanes + len(FREE_FROM_START)
            return replace(model, problem=replace(model.problem, capacity=lanes))
        return augment(
            self.plain,
            self.base,
            self._superset([n for n in names if n in self.unlisted_terms]),
            [*names],
            disturbances,
            name,
        )

    def laws(self) -> Iterator[Law]:
        """Yield the laws that may replace the mechanism's."""
        if self.allows_terms:
            yield from rivals_of(self.plain.space.mechanism, grown_only=True)

    def with_law(self, law: Law) -> Families:
        """Return the families with a law in place of the mechanism's own one."""
        return replace(self, law=law)

    def model_with_law(self, law: Law, base: AugmentedModel | None = None) -> AugmentedModel:
        """Return the model with a law in place of the mechanism's own one, and with the effects of another model."""
        other = self.with_law(law)
        if base is None or not base.effects:
            return other.bare
        tables = missing_tables(other.base.mechanism, base.disturbances)
        added = lay_out(other.base, base.added.terms, tables)
        problem = added.problem(self.plain, base.disturbances)
        return AugmentedModel(f"{base.name}, {law.name}", problem, added, base.disturbances, None, other.base)


def _periods(extension: Extension) -> int:
    shape = extension.structure
    return int(shape["order"]) if "order" in shape else round(360.0 / float(shape["period_deg"]))


def places_of(table: str) -> int:
    """Return the number of places of one plant for unlisted terms of a list."""
    return STAGES.slow_at_once if table in SLOW else STAGES.unlisted_at_once
