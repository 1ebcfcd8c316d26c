"""Rungs that add effects. Truth: growths and looks made by hand, and options of a campaign."""

from dataclasses import replace

import pytest

import mechid
from incomplete.benches import make_bench
from incomplete.sizes import SIZES
from ladder_bench import SAMPLES, climb_of_one_record, followed
from mechid.campaign import load_campaign
from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.search.multistart import Candidate
from mechid.identification.stages import effect_rungs
from mechid.identification.stages.effect_rungs import tune_periods
from mechid.identification.stages.first_look import FirstLook
from mechid.identification.stages.term_growth import GrownModel
from recovery.mechanisms import FAMILIES


@pytest.fixture(scope="module")
def climb():
    return climb_of_one_record()


def test_friction_over_the_angle_takes_the_order_that_longer_windows_tell(climb, monkeypatch):
    """Truth: by hand: order 29 leaves less; what then comes less far is not taken."""
    families, q = climb.families, climb.best.q
    first, better = (families.with_effect(families.bare, f"friction.position:output:{k}") for k in (28, 29))
    grown, seen = GrownModel(first, followed(first.problem.start, 400)), []

    def look(*given):
        seen.append(given[3:5])
        return FirstLook(better, better.problem.start, 1.0, 600)

    monkeypatch.setattr(effect_rungs, "look_at_periods", look)
    for samples, taken in ((SAMPLES, True), (300, False)):
        again = GrownModel(better, followed(better.problem.start, samples))
        monkeypatch.setattr(effect_rungs, "grow_model", lambda *_args, again=again, **_options: again)
        assert tune_periods(climb, families, grown) is (again if taken else grown)
    assert seen[0] == ("friction.position:output:28", {"full_46": (0, SAMPLES)}), "0.1 s past the horizon at least"
    bare = GrownModel(families.bare, followed(q, 400))
    assert tune_periods(climb, families, bare) is bare
    assert [term for term, _ in seen] == [f"friction.position:output:{k}" for k in (28, 29, 28)], "none of the bare one"


def test_effects_are_added_only_where_the_campaign_lets_them(climb):
    """Truth: [identify] terms and disturbances."""
    for terms, disturbances, allowed in ((True, "none", True), (False, "auto", True), (False, "none", False)):
        options = IdentifyOptions(terms=terms, disturbances=disturbances)
        one = replace(climb, campaign=replace(climb.campaign, options=options), best=Candidate(climb.best.q, 1e6))
        assert one.may_add is allowed
        assert effect_rungs.NAMED_EFFECTS[0].applies(one) is allowed


def test_more_starts_are_taken_only_where_they_follow_further(climb, monkeypatch):
    """Truth: by hand: costs of the start behind the usual ones, and how far it is followed; 100 samples before."""
    unexplained = replace(climb, best=Candidate(climb.best.q, 1e6))
    for cost, samples, taken in ((1e3, SAMPLES, True), (1e3, 60, False), (2e6, SAMPLES, False)):
        start = Candidate(climb.best.q, cost)
        monkeypatch.setattr(effect_rungs, "refine_more_starts", lambda *_, start=start: start)
        growth = followed(start.q, samples)
        monkeypatch.setattr(effect_rungs, "grow_starts", lambda *_args, growth=growth, **_options: growth)
        after = effect_rungs._grow_from_more_starts(unexplained)
        assert (after.best is start, after.growth is growth) == (taken, taken)
    monkeypatch.setattr(effect_rungs, "refine_more_starts", lambda *_: None)
    assert effect_rungs._grow_from_more_starts(unexplained) is unexplained


@pytest.mark.slow
def test_hum_that_the_records_show_is_grown_from_starts_without_it(tmp_path):
    """Truth: 60 Hz in a bench of hardware sizes; the starts drawn with hum in the records imitate it, at 2.6."""
    bench = make_bench("mains_hum", 107, tmp_path, sizes=SIZES["hardware"], catalogue=True)
    fit = mechid.identify(replace(load_campaign(bench.folder), mechanism=FAMILIES[1].catalogue()), workers=1)
    assert fit.path == ("as written", "mains hum")
    assert [one.name for one in fit.missing] == ["mains:60Hz"]
    assert fit.grade == "A"


@pytest.mark.parametrize(("left", "grown"), [(600.0, True), (7e5, False)])
def test_new_starts_beside_hum_are_grown_where_they_explain_most(climb, monkeypatch, left, grown):
    """Truth: by hand: what the best new start leaves of 1e6 that the best of the usual ones leaves."""
    unexplained = replace(climb, best=Candidate(climb.best.q, 1e6))
    families, q = climb.families, climb.best.q
    monkeypatch.setitem(vars(families), "seen_grids", (50.0,))
    monkeypatch.setattr(effect_rungs, "refine_best_start", lambda *_: Candidate(q, left))
    costs = {(): 1e6, ("mains:50Hz",): left}
    looked = lambda model, at, *_: FirstLook(model, at, costs[model.effects], 600)  # noqa: E731
    monkeypatch.setattr(effect_rungs, "fit_look", looked)
    growth = followed(q, SAMPLES)
    monkeypatch.setattr(effect_rungs, "grow_model", lambda _, model, *_args, **_options: GrownModel(model, growth))
    after = effect_rungs._grow_from_starts_beside_hum(unexplained, 50.0)
    assert (after.reached is not None and after.reached.model.effects == ("mains:50Hz",)) is grown
