"""Ranking of single effects. Truth: what made the records, a detent of 130 periods or friction over the angle."""

import numpy as np
import pytest

from detent_bench import PERIODS, detent_bench
from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.computation.journal import Journal
from mechid.identification.identify import make_problem
from mechid.identification.stages.effect_ranking import _scores, effect_scores, rank_effects
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import first_windows, fit_look
from synthetic import COMMANDS, TRUTH, campaign, measured, record

ORDER, SECONDS = 5, 0.6


@pytest.fixture(scope="module")
def uneven():
    """Return families of a mechanism without the friction over the angle that made the records."""
    friction = {**CATALOGUE["friction"], "position": [{"order": ORDER, "amplitude": 0.25, "phase_deg": 40.0}]}
    made_by = mechanism_from_table({**CATALOGUE, "friction": friction}, "uneven").with_values(TRUTH)
    rng = np.random.default_rng(4)
    records = [
        record(name, measured(made_by, COMMANDS[name], rng, seconds=SECONDS), COMMANDS[name])
        for name in ("full_46", "micro_92")
    ]
    free = ("gear.stiffness", "stepper.torque_constant", "friction.coulomb", "friction.static")
    made = campaign(catalogue_mechanism().with_values(TRUTH).with_free(free), *records)
    return Families(make_problem(made, 1), made)


@pytest.mark.slow
def test_the_likeliest_single_effect_has_nearly_the_right_number_of_periods():
    """Truth: 130 periods, of which over the first moments 129 or 131 explain nearly as much."""
    made = detent_bench()
    families = Families(make_problem(made, 1), made)
    plain, windows = families.plain, first_windows(families.plain)
    q = fit_look(families.bare, plain.start, Journal()).q
    listed, slow, detents = rank_effects(families, families.bare, q, windows)
    assert slow == []
    assert families.periods(detents[0]) == pytest.approx(PERIODS, rel=0.03)
    near = [families.periods(name) for name in detents]
    assert sum(abs(one / PERIODS - 1.0) < 0.05 for one in near) == 1, "of neighbours the best one alone is ranked"
    assert not any(name in families.unlisted_terms for name in listed)
    assert "stepper.torque_harmonic:3" not in listed[:2]


@pytest.mark.slow
def test_friction_over_the_angle_is_alone_with_its_order(uneven):
    """Truth: 5 periods a turn of the rotor, of which the records see one and a half."""
    of_records, listed, found = rank_effects(uneven, uneven.bare, uneven.plain.start, uneven.plain.whole_windows())
    assert set(of_records) <= {"record.delay", "record.voltage", "record.gain", "clock"}
    assert not any(uneven.is_slow(name) for name in listed)
    assert found[0] == f"friction.position:{ORDER}"
    assert uneven.is_slow(found[0])
    assert uneven.periods(found[0]) == ORDER


@pytest.mark.slow
def test_first_moments_are_not_asked_for_friction_over_the_angle(uneven):
    """Truth: windows of 60 ms, in which the rotor turns by 10 degrees."""
    kinds = rank_effects(uneven, uneven.bare, uneven.plain.start, first_windows(uneven.plain))
    assert not any(uneven.is_slow(name) for names in kinds for name in names)


@pytest.mark.slow
def test_a_plant_has_places_for_friction_over_the_angle_where_one_is_named(uneven):
    """Truth: parameters by name; two orders share a plant."""
    usual = uneven.with_effect(uneven.bare, "record.delay").problem.space.mechanism
    assert not any(name.startswith("friction.position") for name in usual.parameters)
    one, other = (uneven.with_effect(uneven.bare, f"friction.position:{k}") for k in (2, 7))
    assert one.problem.space.mechanism.plant.digest == other.problem.space.mechanism.plant.digest
    assert uneven.with_periods("friction.position:2", 7) == "friction.position:7"
    assert uneven.with_periods("friction.position:2", 9) is None


@pytest.mark.slow
def test_effects_of_every_kind_are_compared_over_the_first_seconds(uneven):
    """Truth: friction over the angle, 5 periods a turn, beside which nothing listed and no detent explains as much."""
    scores = effect_scores(uneven, uneven.bare, uneven.plain.start)
    assert max(scores, key=scores.__getitem__) == f"friction.position:{ORDER}"
    assert {"record.gain", "stepper.torque_harmonic:3"} <= set(scores)
    assert any(name.startswith("stepper.detent:") for name in scores)


@pytest.mark.slow
def test_the_number_of_periods_of_a_detent_is_exact_over_whole_records():
    """Truth: 130 periods; the scan in steps passes over it, its neighbours are compared again."""
    made = detent_bench(0.6)
    families = Families(make_problem(made, 1), made)
    scores = effect_scores(families, families.bare, families.plain.start)
    assert families.periods(max(scores, key=scores.__getitem__)) == PERIODS


@pytest.mark.slow
def test_a_scan_without_places_for_other_terms_gives_the_same_scores(uneven):
    """Truth: the plant that has the whole library beside the scanned terms."""
    windows, base = uneven.plain.whole_windows(), uneven.bare
    names = [f"friction.position:{order}" for order in (3, ORDER)]
    laid_out = base.lay_out_with(uneven.plain, names, uneven.record_tables)
    wide = uneven.with_effects(base, names, (), "scanned")
    assert laid_out.problem.shrinkage == pytest.approx(
        {name: width for name, width in wide.problem.shrinkage.items() if name in laid_out.problem.shrinkage}
    )
    assert len(laid_out.problem.space.mechanism.plant.parameters) < 40
    found, expected = (_scores(base, uneven.plain.start, windows, one, names) for one in (laid_out, wide))
    assert found == pytest.approx(expected, rel=1e-6)
    assert max(found, key=found.get) == names[1]
