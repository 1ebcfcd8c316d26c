"""The tuple of detectors: a misreading that is put into it reaches `check` and the first step of `identify`."""

from dataclasses import replace

import numpy as np
import pytest

import mechid
from layouts import changed
from mechid.campaign import catalogue_mechanism, mechanism_from_table
from mechid.campaign.campaign import Stage
from mechid.command import RateProfile
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading
from mechid.identification.readings import detectors, misreading
from mechid.identification.readings.detectors import apply_findings, declaration_warnings, find_all
from mechid.identification.readings.finding import Confidence, DeclaredRecords, Finding
from mechid.identification.readings.misreading import RATE, confirm_rates
from mechid.identification.readings.trial import Trial
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.multistart import Candidate
from paper import constant
from recovery.mechanisms import paper_table
from synthetic import COMMANDS, campaign, measured, record, truth

NAMES = ("full_46", "micro_46")
UPSIDE_DOWN = "its torque hangs upside down"


def find_upside_down(records, earlier):
    """Detect records with a negative mean torque."""
    for target in records.readable:
        if np.mean(target.leading.measured[:]) < 0.0:
            yield Finding(
                (target.name,),
                "upside down",
                UPSIDE_DOWN,
                "turn it round",
                Confidence.CONFIRMED,
                {target.name: Reading(polarity=-1)},
            )


@pytest.fixture
def bench(monkeypatch):
    """Return a campaign one of whose records the toy detector finds, as the only detector that there is."""
    monkeypatch.setattr(detectors, "DETECTORS", (find_upside_down,))
    y = {name: measured(truth(), COMMANDS[name], np.random.default_rng(k), seconds=0.2) for k, name in enumerate(NAMES)}
    level = {"full_46": 1.0, "micro_46": -1.0}
    return campaign(
        catalogue_mechanism(), *(record(name, y[name] - y[name].mean() + level[name], COMMANDS[name]) for name in NAMES)
    )


def begun(bench):
    """Return a campaign and its state after the first step of identify."""
    problem = make_problem(bench, 1)
    return apply_findings(bench, SearchState(problem, problem.start, problem.whole_windows()), 0)


def test_check_prints_what_a_new_detector_finds(bench):
    """Truth: the one record that the toy detector was given; check reads nothing otherwise."""
    assert declaration_warnings(bench) == (f"record micro_46: {UPSIDE_DOWN}; turn it round",)
    assert mechid.check(bench).found[0] == f"record micro_46: {UPSIDE_DOWN}; turn it round"


def test_the_first_step_of_identify_reads_the_record_so(bench):
    """Truth: the samples of the record with the other sign."""
    warned, state = begun(bench)
    assert warned.warnings[0] == f"record micro_46: {UPSIDE_DOWN} (read so in this fit); turn it round"
    assert state.readings == {"micro_46": Reading(polarity=-1)}
    before, after = (p.targets[1].leading.measured[:] for p in (make_problem(bench, 1), state.problem))
    np.testing.assert_array_equal(after, -before)


def test_stages_of_the_user_take_records_as_declared(bench):
    staged = replace(bench, stages=(Stage(records=NAMES, window_s=None, free=("gear.stiffness",)),))
    warned, state = begun(staged)
    assert warned.warnings[0] == f"record micro_46: {UPSIDE_DOWN}; turn it round"
    assert state.readings == {}


def test_what_is_ambiguous_is_said_and_not_used(bench, monkeypatch):
    def unsure(records, earlier):
        return (replace(one, confidence=Confidence.AMBIGUOUS) for one in find_upside_down(records, earlier))

    monkeypatch.setattr(detectors, "DETECTORS", (unsure,))
    warned, state = begun(bench)
    assert warned.warnings[0] == f"record micro_46: {UPSIDE_DOWN}; turn it round"
    assert state.readings == {}


def test_a_detector_is_given_the_findings_before_it(bench, monkeypatch):
    """Truth: the order of the tuple."""
    seen = []

    def second(records, earlier):
        seen.append([one.cause for one in earlier])
        return ()

    monkeypatch.setattr(detectors, "DETECTORS", (find_upside_down, second))
    find_all(DeclaredRecords(bench, make_problem(bench, 1)))
    assert seen == [["upside down"]]


FULL = measured(truth(), COMMANDS["full_46"], np.random.default_rng((7, 0)), seconds=1.0)
OTHER = measured(truth(), COMMANDS["micro_46"], np.random.default_rng((7, 2)), seconds=1.0)


@pytest.mark.slow
def test_a_wrong_rate_is_still_used():
    """Truth: 46 full steps/s, declared 31; no term that the mechanism lacks makes up for it."""
    bench = campaign(
        catalogue_mechanism(),
        record("full_46", FULL, constant(31.0)),
        record("micro_46", OTHER, COMMANDS["micro_46"]),
    )
    warned, state = begun(bench)
    assert state.readings["full_46"].rate.rates[0] == pytest.approx(46.0, rel=1e-3)
    assert "read so in this fit" in warned.warnings[0]


@pytest.mark.parametrize(("declared", "other", "confirmed"), [(30.0, 1.2, True), (1.1, 1.0, False), (3.0, 2.5, False)])
def test_a_rate_is_used_only_where_terms_do_not_explain_the_declared_one(monkeypatch, declared, other, confirmed):
    """Truth: the costs of both, which the comparison is made to give."""
    bench = campaign(catalogue_mechanism(), record("full_46", FULL, COMMANDS["full_46"]))
    asked = {}

    def compared(problem, readings, *, with_terms):
        asked["with_terms"] = with_terms
        return [Trial(Candidate(problem.start, cost), cost, 1e4) for cost in (declared, other)]

    monkeypatch.setattr(misreading, "compare_readings", compared)
    rate = Finding(
        ("full_46",),
        RATE,
        "seems to be another",
        confidence=Confidence.CONFIRMED,
        reading={"full_46": Reading(rate=RateProfile.constant(23.0))},
    )
    (found,) = confirm_rates(DeclaredRecords(bench, make_problem(bench, 1)), (rate,))
    assert asked == {"with_terms": True}
    assert found.is_confirmed == confirmed
    assert ("not read so" in found.line()) != confirmed


@pytest.mark.slow
def test_offsets_of_the_phases_are_not_read_as_half_the_rate():
    """Truth: phase offsets of 0.25 and -0.25 V, which the file lacks; the command is as declared."""
    table = changed(paper_table(), {"stepper": {"imbalance": {"offset_a": 0.25, "offset_b": -0.25}}})
    values = {name: truth().value(name) for name in truth().parameters}
    offset = mechanism_from_table(table, "with offsets").with_values(values)
    rng = np.random.default_rng(7)
    y = {name: measured(offset, COMMANDS[name], rng, seconds=0.5) for name in ("full_46", "full_23", "micro_46")}
    bench = campaign(catalogue_mechanism(), *(record(name, one, COMMANDS[name]) for name, one in y.items()))
    reading = {"full_46": Reading(rate=RateProfile.constant(23.0))}
    half = Finding(("full_46",), RATE, "seems to be half", confidence=Confidence.CONFIRMED, reading=reading)
    (found,) = confirm_rates(DeclaredRecords(bench, make_problem(bench, 1)), (half,))
    assert found.confidence is Confidence.AMBIGUOUS
    assert found.reading == reading
