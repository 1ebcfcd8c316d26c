"""A tab without a browser. Truth: the simulation itself, differences, the Jacobian of the fit, the record's noise."""

import math
import time
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import synthetic
from diagnosis_folder import DETENT
from layouts import mechanism_of
from mechid.campaign import load_mechanism
from mechid.errors import UsageError
from mechid.identification.computation.progress import Progress
from mechid.simulation.interruption import check_interruption
from mechid.web import Source
from mechid.web.estimate import Estimate
from mechid.web.fit_content import progress_curves
from mechid.web.fit_run import FitRun, RunState
from mechid.web.page_content import shown_data
from mechid.web.session import MOST_SHOWN, Session
from turned import TRUTH, at_truth

SECONDS = 60.0


def ended(session):
    """Wait until the fit has ended, and take it up."""
    until = time.monotonic() + SECONDS
    while session.is_fitting and time.monotonic() < until:
        time.sleep(0.02)
    assert session.run.state is RunState.FINISHED, session.run.fault
    assert session.adopt_result()


def test_explained_is_said_where_the_residual_is_the_noise_and_not_where_it_is_a_sixth_above(session):
    """Truth: the noise that the bench drew; a knob turned until the residual's RMS is 1.16 times that of the truth."""

    def panel():
        pictures = session.pictures()
        return pictures["full_46"].numbers.residual, shown_data(session, pictures, {}, {})["records"][0]

    at_truth(session)
    assert [panel()[1][key] for key in ("words", "grade")] == ["No larger than the noise.", "good"]
    near, far = TRUTH["gear.stiffness"], 1.1 * TRUTH["gear.stiffness"]
    for _ in range(40):
        session.turn("gear.stiffness", 0.5 * (near + far))
        near, far = (0.5 * (near + far), far) if panel()[0].ratio < 1.16 else (near, 0.5 * (near + far))
    residual, said = panel()
    assert residual.ratio == pytest.approx(1.16, abs=0.002)
    assert said["grade"] == "caution"
    assert said["words"].startswith("1.16 times the noise floor, ")


def test_a_record_that_a_fit_left_out_is_called_so_and_stays_one_to_estimate_from(source, campaign):
    """Truth: the campaign's own entries; the sweep alone is held out by its file."""
    values = {q.name: q.value for q in campaign.parameters.values()}
    taken = tuple(replace(r, use="validate") if r.name == "micro_46" else r for r in campaign.records)
    estimate = Estimate(
        source="a fit", values=values, sigmas={}, summary={}, records=taken, left_out=frozenset({"micro_46"})
    )
    session = Session(replace(source, estimate=estimate))
    uses = shown_data(session, session.pictures(), {}, {})["uses"]
    assert uses == {"full_46": "", "micro_46": "left out of the last fit", "sweep": "held out"}
    session._adopt_estimate(estimate)
    assert [r.use for r in session.campaign.records] == ["estimate", "estimate", "validate"]


def test_what_is_offered_first_is_the_search_at_the_file_values_and_the_fit_elsewhere(source, campaign):
    """From the catalogue a fit mostly ends elsewhere; from values set by hand, or an estimate, it is what is wanted."""

    def offered(session):
        return shown_data(session, {}, {}, {})["primary"]

    session = Session(source)
    assert offered(session) == "search"
    session.turn("load.inertia", 0.011)  # which no fit moves
    assert offered(session) == "search"
    session.turn("gear.stiffness", TRUTH["gear.stiffness"])
    assert offered(session) == "fit"
    session.to_file()
    assert offered(session) == "search"
    values = {name: q.value for name, q in campaign.parameters.items()}
    there = Estimate(source="the file's own", values=values, sigmas={}, summary={}, records=campaign.records)
    assert offered(Session(replace(source, estimate=there))) == "fit"


def test_turning_a_knob_moves_the_model_and_worsens_the_residual(session):
    before = at_truth(session).pictures()["full_46"]
    session.turn("gear.stiffness", 1000.0)
    after = session.pictures()["full_46"]
    assert np.abs(after.modelled - before.modelled).max() > 0.05
    assert after.numbers.residual.ratio > 10.0
    session.undo()
    assert np.array_equal(session.pictures()["full_46"].modelled, before.modelled)


def test_a_fit_from_here_finds_the_truth_and_undo_takes_it_back(session):
    start = session.state.now
    session.fit_from_here()
    with pytest.raises(UsageError, match="cancel"):
        session.search()
    ended(session)
    estimate = session.estimate
    for name, true in TRUTH.items():
        assert session.state.now.values[name] == estimate.values[name]
        assert abs(estimate.sigmas_from(name, true)) < 4.0
    assert estimate.summary["tone"] in ("good", "caution")
    assert [q["question"] for q in estimate.summary["questions"]][1] == "What is least certain?"
    session.undo()
    assert session.state.now == start


def test_the_course_of_a_fit_ends_where_the_fit_does(session):
    session.fit_from_here()
    ended(session)
    ratios, places = progress_curves(session.run.reports, session.state.knobs)
    assert ratios["worst"][0][1] > 10.0
    for own in ratios.values():
        assert own[-1] == (len(session.run.reports), pytest.approx(1.0, abs=0.05))
    for name in TRUTH:
        knob = session.state.knobs[name]
        assert places[name][-1][1] == pytest.approx(knob.place(session.estimate.values[name]), abs=1e-6)
        assert places[name][0][1] != places[name][-1][1]


@pytest.mark.slow
def test_the_course_of_a_fit_that_explains_nothing_ends_as_far_off_as_its_records_are(session):
    """Truth: the residual of each whole record, measured less simulated, over the noise that the bench drew."""
    session.set_free("gear.stiffness", is_free=False)
    session.fit_from_here()
    ended(session)
    names = ("full_46", "micro_46")
    session.look(names, 1e9)
    pictures = session.pictures()
    off = [float(np.sqrt(np.mean(pictures[name].residual ** 2))) / synthetic.NOISE_NM for name in names]
    ratios, _ = progress_curves(session.run.reports, session.state.knobs)
    assert min(off) > 2.0
    assert ratios["worst"][-1][1] == pytest.approx(max(off), rel=0.05)
    assert ratios["median"][-1][1] == pytest.approx(sum(off) / 2.0, rel=0.05)
    before = next(r.over_noise for r in session.run.reports[-3::-1] if r.over_noise)  # of the search itself
    assert max(before.values()) > 2.0


@pytest.mark.slow
def test_what_is_held_stays_and_a_fit_that_is_cancelled_changes_nothing(session):
    session.set_free("gear.damping", is_free=False)
    session.turn("gear.damping", 0.4)
    session.fit_from_here()
    ended(session)
    assert session.state.now.values["gear.damping"] == 0.4
    was, estimate = session.state, session.estimate
    session.search()
    session.cancel()
    assert session.run.wait(SECONDS)
    assert session.run.state is RunState.CANCELLED
    assert not session.adopt_result()
    assert (session.state, session.estimate) == (was, estimate)


def test_a_cancelled_run_ends_also_where_it_has_nothing_to_report():
    def endless(told):
        while True:
            check_interruption()

    run = FitRun(endless)
    run.start()
    run.cancel()
    assert run.wait(SECONDS)
    assert (run.state, run.result) == (RunState.CANCELLED, None)


def test_the_course_of_a_long_fit_is_thinned_and_keeps_its_end(session):
    reports = [Progress(1, 4, "multi-start", "", 1e4 / k, 0.0, {"gear.stiffness": 900.0 + k}) for k in range(1, 5001)]
    ratios, places = progress_curves(reports, session.state.knobs)
    assert 250 < len(places["gear.stiffness"]) < 700
    assert places["gear.stiffness"][-1][0] == 5000
    assert ratios == {"worst": [], "median": []}


def test_a_record_that_is_lost_leaves_a_gap_in_the_course(session):
    """Truth: the worst and the median of the numbers written here."""
    told = ({"a": 3.0, "b": 9.0, "c": 5.0}, {}, {"a": 2.0, "b": math.inf, "c": 4.0})
    reports = [Progress(1, 4, "gated growth", "", None, 0.0, over_noise=own) for own in told]
    ratios, _ = progress_curves(reports, session.state.knobs)
    assert ratios == {"worst": [(1, 9.0)], "median": [(1, 5.0), (3, 4.0)]}


def test_an_effect_is_there_also_where_nothing_is_free(campaign):
    held = Session(Source(replace(campaign, mechanism=campaign.mechanism.with_free(()))))
    held.take("gear.stiffness")
    assert held.effects()["full_46"].rms > 1e-4


def test_a_fit_that_cannot_be_made_says_why(session):
    for name in TRUTH:
        session.set_free(name, is_free=False)
    session.fit_from_here()
    assert session.run.wait(SECONDS)
    assert session.run.state is RunState.FAILED
    assert "no parameter to estimate" in session.run.fault


def test_the_saved_mechanism_reads_back_to_the_settings(session, tmp_path):
    session.turn("gear.stiffness", 987.654321)
    session.turn("load.inertia", 0.0111)
    session.set_free("load.inertia", is_free=True)
    session.set_free("gear.damping", is_free=False)
    path = tmp_path / "mechanism.toml"
    path.write_text(session.mechanism_file(), encoding="utf-8")
    read = load_mechanism(path)
    assert {
        q.name: q.value for q in read.parameters.values() if q.name in session.state.knobs
    } == session.state.now.values
    assert {q.name for q in read.free} == {"gear.stiffness", "load.inertia"}


def test_two_tabs_share_nothing_that_can_be_set(source):
    one, other = Session(source), Session(source)
    one.turn("gear.stiffness", 1234.0)
    one.set_free("gear.damping", is_free=False)
    one.look(("micro_46",), 0.1)
    assert other.state.now.values["gear.stiffness"] == source.campaign.mechanism.value("gear.stiffness")
    assert "gear.damping" in other.state.now.free
    assert other.shown == ("full_46",)


def test_records_side_by_side_are_the_last_ones_chosen_and_exist(session):
    session.look(("full_46", "micro_46"), 0.1)
    pictures = session.pictures()
    assert list(pictures) == ["full_46", "micro_46"]
    assert all(p.measured.size == 1001 for p in pictures.values())
    session.look(("micro_46",) * (MOST_SHOWN + 2), 1e9)
    assert len(session.shown) == MOST_SHOWN
    assert session.pictures()["micro_46"].measured.size == 2001
    for names, seconds in ((("other",), 1.0), (("full_46",), 0.0)):
        with pytest.raises(UsageError):
            session.look(names, seconds)


def test_terms_that_a_fit_added_have_knobs_once_it_has_ended(lacking, whole):
    """Truth: the mechanism that the records are of, at whose values the residual is the noise; and the file's."""
    source, estimate = lacking
    session = Session(source)
    written = session.pictures()["full_46"]
    assert not set(DETENT) & session.state.knobs.keys()
    session.set_free("gear.stiffness", is_free=False)
    session._adopt_estimate(estimate)
    assert {n: session.state.now.values[n] for n in DETENT} == {n: whole.value(n) for n in DETENT}
    assert set(DETENT) <= session.state.now.free
    assert "gear.stiffness" not in session.state.now.free
    assert session.pictures()["full_46"].numbers.residual.ratio == pytest.approx(1.0, abs=0.05)
    assert len(session.state.past) == 1  # without the term
    assert shown_data(session, {}, {}, {})["apart"] == ""
    assert mechanism_of(tomllib.loads(session.mechanism_file())).value(DETENT[0]) == whole.value(DETENT[0])
    session.to_file()
    ratio = session.pictures()["full_46"].numbers.residual.ratio
    assert ratio == pytest.approx(written.numbers.residual.ratio, rel=1e-4)
    assert ratio > 2.0
    plain = {name: q.value for name, q in source.campaign.parameters.items()}
    session.take(DETENT[0])
    session._adopt_estimate(replace(estimate, mechanism=None, values=plain))
    assert session.state.knobs.keys() == plain.keys() & session.state.knobs.keys()
    assert session.hand in session.state.knobs
