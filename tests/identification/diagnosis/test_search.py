"""Which effects a diagnosis names: those that explain the records, told from those that stand for something else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.command import RateProfile
from mechid.identification.diagnosis import search
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.search import compensating_effects, doubtful_effects, negligible_effect
from mechid.identification.effects.scores import Score
from mechid.identification.identify import identify
from synthetic import COMMANDS, RATE_HZ, TRUTH, campaign, measured, record


@pytest.mark.slow
def test_hum_that_the_fit_has_found_is_named():
    """Truth: 50 Hz of 5 mN m with a third of it at 150 Hz, added to a record whose rate varies."""
    command = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 10.0), (2.0, 60.0)]))
    made_by = catalogue_mechanism().with_values(TRUTH)
    torque = measured(made_by, command, np.random.default_rng(9), seconds=2.0)
    turns = 2.0 * np.pi * 50.0 * np.arange(torque.size) / RATE_HZ
    torque += 5e-3 * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    bench = replace(campaign(made_by, record("sweep", torque, command)), considered=("clock",))
    fit = identify(bench, workers=1, near={p.name: p.value for p in made_by.free})
    assert [one.name for one in fit.missing] == ["mains:50Hz"]
    found = diagnose(fit, workers=1)
    assert [one.name for one in found.missing] == ["mains:50Hz"]


def test_effects_that_stand_for_something_else_are_told_from_those_that_explain():
    """Truth: the rule as the documentation has it: a half where more than noise is left, and three that imitate."""

    def score(share):
        return Score(chi_square=1000.0, dof=1, share=share, effective_samples=1e5)

    def left(ratio):
        return SimpleNamespace(over_noise=ratio)

    assert compensating_effects(left(1.0), {"a": score(0.9), "b": score(0.2)}) == []
    assert compensating_effects(left(1.05), {"a": score(0.9), "b": score(0.2)}) == ["b"]
    assert compensating_effects(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.2)}) == []
    assert compensating_effects(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.05)}) == ["c"]
    assert compensating_effects(left(1.0), {"a": score(0.9), **dict.fromkeys("bcd", score(0.2))}) == [
        "a",
        "b",
        "c",
        "d",
    ]
    five = dict.fromkeys("abcd", score(0.9))
    assert compensating_effects(left(1.0), {**five, "e": score(0.9)}) == []
    assert compensating_effects(left(1.0), {**five, "e": score(0.2)}) == ["a", "b", "c", "d", "e"]


def test_effects_with_which_parts_of_the_records_disagree_are_named_where_they_take_nearly_all(monkeypatch):
    """Truth: the rule that the page states, at both sides of each limit."""

    def score(share):
        return Score(1000.0, 2, share, 1e5)

    def left(over_noise):
        return SimpleNamespace(over_noise=over_noise, cost=1.0)

    needed, less = {"a": score(0.95), "b": score(0.8)}, {"a": left(1.3), "b": left(1.3)}
    monkeypatch.setattr(search, "_agrees", lambda model: True)
    assert doubtful_effects(left(1.0), needed, less) == []
    monkeypatch.setattr(search, "_agrees", lambda model: False)
    assert doubtful_effects(left(1.0), needed, less) == ["b"]
    assert doubtful_effects(left(1.0), needed, {**less, "a": left(1.005)}) == ["a", "b"]
    assert doubtful_effects(left(1.3), needed, less) == []
    assert doubtful_effects(left(1.0), {}, {}) == []


def test_a_small_effect_is_not_named_of_records_followed_in_part():
    """Truth: less than a hundredth of what the largest explains is small, of whole records never."""
    needed = {
        name: SimpleNamespace(chi_square=c) for name, c in {"a": 1e5, "b": 1001.0, "c": 999.0, "d": 500.0}.items()
    }
    part, whole = (SimpleNamespace(is_of_whole_records=one) for one in (False, True))
    assert negligible_effect(part, needed) == "d"
    assert negligible_effect(part, {name: needed[name] for name in "ab"}) == ""
    assert negligible_effect(part, {}) == ""
    assert negligible_effect(whole, needed) == ""
