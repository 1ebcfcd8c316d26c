"""Families of effects that a mechanism or its records may have, as models of one problem."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.campaign.identify_options import MAINS
from mechid.identification.effects.augmented import AugmentedModel, augment
from mechid.identification.effects.campaign_disturbances import possible
from mechid.identification.effects.disturbance import Disturbance, lacking_tables
from mechid.identification.effects.effect import MOST_PERIODS, AddedTerms, lay_out, substitute_law
from mechid.identification.effects.mains import mains
from mechid.identification.effects.pruning import falls, groups_of
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.multistart import robust_triangle
from mechid.identification.search.rest import commanded_rest_of
from mechid.identification.stages.settings import STAGES
from mechid.plant.block import Extension
from mechid.plant.law import Law
from mechid.plant.superset import Superset, rivals_of, superset_of, unlisted_extensions
from mechid.signal.settings import HUM

GAIN_TABLE = "transducer"
"""The table that holds the gain of the test stand: a record may have one of its own only where it is there."""
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
        """Terms of any other whole number of periods in a turn of the rotor, by name."""
        return unlisted_extensions(self.base.mechanism, range(1, MOST_PERIODS + 1))

    def periods(self, name: str) -> int:
        """Return the number of periods in a turn of an unlisted term."""
        return _periods(self.unlisted[name])

    def named(self, periods: int) -> str | None:
        """Return the name of the unlisted term of a number of periods in a turn; None where there is none."""
        return self._by_number.get(periods)

    @cached_property
    def _by_number(self) -> dict[int, str]:
        return {_periods(e): name for name, e in self.unlisted.items()}

    def _superset(self, names: Iterable[str]) -> Superset | None:
        """Return the superset with some of the unlisted terms too: the same plant whichever they are."""
        layout = self.base.mechanism.plant.layout
        if layout is None:
            return None
        chosen = [*names, *(name for name in self.unlisted if name not in names)][: STAGES.unlisted_at_once]
        further = [self.unlisted[name] for name in chosen] if self.allows_terms else []
        tables = (GAIN_TABLE,) if layout.flying is None else ()
        return superset_of(self.base.mechanism, grown_only=True, further=further, tables=tables)

    @cached_property
    def _of_records(self) -> tuple[Disturbance, ...]:
        bare = augment(self.plain, self.base, self.superset, (), (), "").problem
        rests = {t.name: commanded_rest_of(t) for t in self.plain.targets}
        return tuple(
            one for one in possible(bare, self.campaign, rests=rests) if one.name in OF_RECORDS or one.lines_hz
        )

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
        return self._with(base, names, own, family.name)

    @cached_property
    def unseen_grids(self) -> tuple[float, ...]:
        """Nominal frequencies of the grid, Hz, whose hum the records may hide; none where it is seen or excluded."""
        allowed = self.campaign.options.disturbances
        if any(one.lines_hz for one in self._of_records) or not (allowed == "auto" or MAINS in allowed):
            return ()
        return () if any(t.leading.turns for t in self.plain.targets) else HUM.mains_hz

    def with_hum(self, grid_hz: float, q: FloatArray, horizons: Mapping[str, int]) -> AugmentedModel | None:
        """Return the model with nothing beside but hum, at the frequency that what is followed of the records tells.

        None where too little is followed of any record.

        Parameters
        ----------
        grid_hz : float
            Nominal frequency, which holds where they do not tell it.
        q : (n,)
            Of the mechanism as written.
        horizons : mapping of record to int
            Samples that it follows there.
        """
        followed = replace(self.plain, targets=tuple(t.beginning(horizons[t.name]) for t in self.plain.targets))
        hum = mains(followed, q, grid_hz)
        return augment(self.plain, self.base, None, (), (hum,), hum.name) if hum else None

    def with_effect(self, base: AugmentedModel, name: str) -> AugmentedModel:
        """Return a model with one more effect, a term or a disturbance, by its name."""
        one = next((one for one in self._of_records if one.name == name), None)
        words = f"{base.name}, {name}" if base.effects else name
        return self._with(base, () if one else (name,), (one,) if one else (), words)

    def with_other_term(self, base: AugmentedModel, old: str, new: str) -> tuple[AugmentedModel, dict[str, str]]:
        """Return a model with another term in place of one, and the names of that one's parameters in it."""
        less = base.keeping(self.plain, set(base.effects) - {old}, base.name)
        other = self._with(less, (new,), (), base.name.replace(old, new))
        before, after = base.added.names_by_term[old], other.added.names_by_term[new]
        return other, dict(zip(before, after, strict=True))

    def _with(
        self, base: AugmentedModel | None, terms: Sequence[str], own: Sequence[Disturbance], name: str
    ) -> AugmentedModel:
        before = base or self.bare
        names = dict.fromkeys((*before.added.terms, *terms))
        there = {one.name for one in before.disturbances}
        disturbances = (*before.disturbances, *(one for one in own if one.name not in there))
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

    def likeliest(self, base: AugmentedModel, q: FloatArray, windows: Windows) -> list[str]:
        """Return the listed single effects that would explain most of some windows beside a model, the likeliest first.

        By the derivatives at a point: with each effect all that the model has is free to make room.

        Parameters
        ----------
        base : AugmentedModel
        q : (n,)
            A point of it.
        windows : mapping of record to (first, stop)
        """
        return _best(self._scores(base, q, windows, self.model(EVERYTHING, base), None), STAGES.singles)

    def likeliest_unlisted(self, base: AugmentedModel, q: FloatArray, windows: Windows) -> list[str]:
        """Return the terms of any number of periods that would explain most beside a model, the likeliest first.

        As `likeliest`; long windows are judged by their first moments alone. Of terms with neighbouring numbers of
        periods, which short windows do not tell apart, the best one is returned.
        """
        found, short = dict[str, float](), self._at_most_long(windows)
        numbers = self._scanned(base)
        for first in range(0, len(numbers), STAGES.unlisted_at_once):
            some = [name for _, name in numbers[first : first + STAGES.unlisted_at_once]]
            found |= self._scores(base, q, short, self._with(base, some, (), "scanned"), some)
        return _best({n: s for n, s in found.items() if not self._is_beside_better(n, numbers, found)}, STAGES.singles)

    def _at_most_long(self, windows: Windows) -> Windows:
        """Return windows of so many seconds at most: the shortest as they are, of the others the first moments."""
        kept, left_s = {}, STAGES.scan_s
        for target in sorted(self.plain.targets, key=lambda t: windows[t.name][1]):
            left_s -= windows[target.name][1] / target.base.sample_rate_hz
            kept[target.name] = windows[target.name] if left_s > 0.0 else first_window(target)
        return kept

    def _scanned(self, base: AugmentedModel) -> list[tuple[int, str]]:
        """Return the numbers of periods at which unlisted terms are looked for, with their names, in steps."""
        if not self.allows_terms or any(name in self.unlisted for name in base.effects):
            return []
        chosen, last = [], 0.0
        for number in sorted(self._by_number):
            if number >= STAGES.scan_step * last:
                chosen.append((number, self._by_number[number]))
                last = number
        return chosen

    def _scores(
        self, base: AugmentedModel, q: FloatArray, windows: Windows, wide: AugmentedModel, names: Sequence[str] | None
    ) -> dict[str, float]:
        """Return what each effect that a wide model has beside another one explains, less k ln N."""
        at, problem = wide.point_of(base, q), wide.problem
        triangle = combine_triangles([robust_triangle(problem, at, windows), *problem.prior_triangles(at)])
        further = {n: own for n, own in wide.names_by_effect.items() if n not in base.effects}
        groups = groups_of(problem, {n: own for n, own in further.items() if names is None or n in names})
        penalty = bayesian_penalty(triangle.samples)
        found = falls(triangle, groups)
        return {name: fall - penalty * len(groups[name]) for name, fall in found.items() if math.isfinite(fall)}

    def _is_beside_better(self, name: str, numbers: Sequence[tuple[int, str]], found: Mapping[str, float]) -> bool:
        names = [one for _, one in numbers]
        if name not in names:
            return False
        k = names.index(name)
        return any(found[other] > found[name] for other in names[max(k - 1, 0) : k + 2] if other != name)


def _best(scores: Mapping[str, float], most: int) -> list[str]:
    """Return the names of the best scores above none, the best first."""
    return sorted((name for name, score in scores.items() if score > 0.0), key=lambda name: -scores[name])[:most]


def _periods(extension: Extension) -> int:
    return round(360.0 / float(extension.structure["period_deg"]))
