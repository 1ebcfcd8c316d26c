"""Selection, pruning and exchange of effects. Truth: candidates whose costs are written down."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import pytest

from mechid.identification.effects.scores import Score
from mechid.identification.effects.selection import (
    add_likeliest,
    better_law,
    drop_unneeded,
    gain,
    is_confirmed,
    is_needed,
    is_significant,
    likely_effects,
)
from mechid.identification.effects.settings import DURING_FIT, IN_DIAGNOSIS, EffectRules

SAMPLES = 1000.0
BOTH = pytest.mark.parametrize("rules", [DURING_FIT, IN_DIAGNOSIS])


@dataclass(frozen=True)
class Sum:
    """A candidate whose effects each take a fixed part of the cost, when fitted; scores may promise something else."""

    takes: dict[str, float]
    rules: EffectRules
    effects: tuple[str, ...] = ()
    promised: dict[str, float] = field(default_factory=dict)
    whole: float = 3.0 * SAMPLES
    fits: list[str] = field(default_factory=list)

    @property
    def cost(self):
        return self.whole - sum(self.takes[name] for name in self.effects)

    @property
    def misfit(self):
        return max(self.cost - SAMPLES, 0.0)

    @property
    def effective_samples(self):
        return SAMPLES

    @property
    def freedom(self):
        return len(self.effects)

    def scores(self):
        further = {name: self.promised.get(name, fall) for name, fall in self.takes.items() if name not in self.effects}
        return {name: Score(SAMPLES * f / (self.cost - f), 1, f / self.cost, SAMPLES) for name, f in further.items()}

    def with_effect(self, effect):
        self.fits.append(effect)
        return replace(self, effects=(*self.effects, effect))

    def without(self, effect):
        return replace(self, effects=tuple(name for name in self.effects if name != effect))

    def is_better_than(self, other):
        return self.cost + 7.0 * self.freedom < other.cost + 7.0 * other.freedom


@BOTH
def test_the_likeliest_effect_is_fitted_and_stays(rules):
    model = Sum({"small": 500.0, "large": 1200.0}, rules)
    tried = {}
    assert add_likeliest(model, tried).effects == ("large",)
    assert model.fits == ["large"]
    assert tried == {}


def test_where_the_likeliest_breaks_its_promise_as_many_are_fitted_as_the_rules_say():
    """Truth: one during a fit; in a diagnosis the second too, and what failed is not fitted again."""
    takes, promised = {"promising": 10.0, "second": 1100.0}, {"promising": 1500.0}
    model = Sum(takes, DURING_FIT, promised=promised)
    assert add_likeliest(model, {}) is None
    assert model.fits == ["promising"]
    model, tried = Sum(takes, IN_DIAGNOSIS, promised=promised), {}
    assert add_likeliest(model, tried).effects == ("second",)
    assert tried == {"promising": "explains 0.5 % of the misfit in a fit"}
    model.fits.clear()
    assert add_likeliest(model, tried).effects == ("second",)
    assert model.fits == ["second"]


@pytest.mark.parametrize(
    ("share", "during", "in_diagnosis"), [(0.6, True, True), (0.3, False, True), (0.05, False, False)]
)
def test_an_effect_has_to_explain_its_share(share, during, in_diagnosis):
    """Truth: half of the misfit during a fit, a tenth in a diagnosis."""
    for rules, stays in ((DURING_FIT, during), (IN_DIAGNOSIS, in_diagnosis)):
        less = Sum({"one": share * 2.0 * SAMPLES}, rules)
        assert is_confirmed(less, less.with_effect("one")) is stays


@BOTH
def test_no_effect_counts_below_its_least_chi_square_or_its_freedom(rules):
    """Truth: 30, and k ln N for N samples."""
    assert is_significant(Score(30.1, 1, 1.0, SAMPLES), rules)
    assert not is_significant(Score(30.0, 1, 1.0, SAMPLES), rules)
    assert not is_significant(Score(40.0, 6, 1.0, SAMPLES), rules)
    assert not is_significant(Score(1e3, 1, 0.2, SAMPLES), rules, least_share=0.3)


def test_the_gain_is_counted_in_effective_samples():
    """Truth: by hand."""
    less = Sum({"one": 1500.0}, IN_DIAGNOSIS)
    found = gain(less, less.with_effect("one"))
    assert (found.chi_square, found.dof, found.share) == (1000.0, 1, 0.75)


def test_a_fit_that_cannot_be_simulated_explains_nothing():
    broken = Sum({"one": 0.0}, DURING_FIT, whole=float("inf"))
    assert not is_confirmed(broken, broken.with_effect("one"))


def test_false_discoveries_are_held_down_in_a_diagnosis_alone():
    """Truth: with the least chi-square out of the way, a chance of 0.1 among a hundred asks for nothing."""
    scores = {str(k): Score(2.7, 1, 0.9, 1.0) for k in range(100)}
    model = Sum({}, replace(IN_DIAGNOSIS, least_chi_square=0.0))
    assert likely_effects(model, scores) == []
    assert len(likely_effects(replace(model, rules=replace(DURING_FIT, least_chi_square=0.0)), scores)) == 100


def test_what_a_fit_does_as_well_without_is_dropped_and_the_last_effect_stays():
    takes = {"needed": 1000.0, "idle": 1.0, "idle too": 2.0}
    model = Sum(takes, IN_DIAGNOSIS, tuple(takes))
    assert [name for name, _ in drop_unneeded(model, model.effects)] == ["idle", "idle too"]
    assert [name for name, _ in drop_unneeded(model, ("idle",))] == ["idle"]
    alone = Sum(takes, IN_DIAGNOSIS, ("idle",))
    assert list(drop_unneeded(alone, alone.effects)) == []


def test_an_effect_stays_during_a_fit_only_with_its_share():
    """Truth: it takes 40 % of what is left without it: enough in a diagnosis, too little during a fit."""
    takes = {"large": 1000.0, "less": 400.0}
    needed = {
        rules: is_needed(Sum(takes, rules, ("large",)), Sum(takes, rules, ("large", "less")))
        for rules in (DURING_FIT, IN_DIAGNOSIS)
    }
    assert needed == {DURING_FIT: False, IN_DIAGNOSIS: True}


def test_the_best_law_takes_its_imitators_place_where_the_criterion_prefers_it():
    takes = {"delay": 900.0, "second order": 950.0, "fourth order": 990.0, "poor": 100.0}
    model = Sum(takes, IN_DIAGNOSIS, ("delay",))

    def fitted(*names):
        return [(SimpleNamespace(name=name), replace(model, effects=(name,))) for name in names]

    law, other = better_law(model, fitted("second order", "fourth order", "poor"))
    assert law.name == "fourth order"
    assert other.effects == ("fourth order",)
    assert better_law(model, fitted("poor")) is None
    assert better_law(model, []) is None
