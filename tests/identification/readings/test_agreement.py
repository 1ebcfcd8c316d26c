"""Records that contradict the others: read otherwise, or left out."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.validation import validate
from mechid.command import RateProfile
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED, Reading
from mechid.identification.readings.agreement import agreement_of_others
from mechid.identification.readings.trial import first_moments
from mechid.identification.result.grade import Cause, FitOutcome, Grade
from mechid.identification.stages import reading_rungs
from odd_records import FACTORS, NAMES, SECONDS, backward, bending, half_steps, made, turned
from synthetic import (
    COMMANDS,
    NOISE_NM,
    displaced,
    torque_of,
    truth,
)

LATE_S = 3e-3


PHASES = ("stepper.detent.0.phase_deg", "stepper.detent.1.phase_deg")


def within(fit, sigmas=5.0):
    """Assert that all estimates of the mechanism lie within some standard errors of what made the records."""
    for name in FACTORS:
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < sigmas * p.std_error, name


CASES = {
    "polarity": ("micro_46", {"polarity": -1.0}, Reading(polarity=-1)),
    "polarity of the first": ("full_46", {"polarity": -1.0}, Reading(polarity=-1)),
    "direction": ("full_23", {"driven": backward}, Reading(direction=-1)),
    "quarter turn": ("full_46", {"driven": lambda c: turned(c, 90.0)}, Reading(start_angle_deg=135.0)),
    "half step": ("full_23", {"driven": lambda c: turned(c, -45.0)}, Reading(start_angle_deg=0.0)),
    "half steps": ("full_23", {"driven": half_steps}, Reading(stepping="half", microsteps=2)),
    "pulses of a finer setting": (
        "micro_46",
        {"driven": lambda c: replace(c, microsteps=2 * c.microsteps, rate=RateProfile.constant(23.0))},
        Reading(stepping="micro", microsteps=32, rate=RateProfile.constant(23.0)),
    ),
    "a microstep": ("micro_46", {"driven": lambda c: turned(c, 5.625)}, Reading(start_angle_deg=5.625)),
}


def as_written_only(bench):
    """Return a campaign whose search adds no effects, so that it comes to other readings of the records at once."""
    return replace(bench, options=replace(bench.options, terms=False, disturbances="none"))


@pytest.mark.parametrize(
    ("case", "limit"),
    [
        ("direction", as_written_only),
        pytest.param("quarter turn", as_written_only, marks=pytest.mark.slow),
        *(pytest.param(case, lambda bench: bench, marks=pytest.mark.slow) for case in CASES),
    ],
)
def test_a_record_that_contradicts_the_others_is_taken_as_it_was(case, limit):
    """Truth: how the record was made, and the mechanism that made all; effects that may be added change nothing."""
    odd, how, taken = CASES[case]
    bench = limit(made(odd, **how))
    fit = identify(bench, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert {name: r.reading for name, r in fit.records.items()} == {**dict.fromkeys(NAMES, DECLARED), odd: taken}
    within(fit)
    (said,) = (w for w in fit.warnings if w.startswith(f"record {odd}:"))
    assert "declared" in said
    assert "write" in said
    content = json.loads(json.dumps(fit.to_dict()))["records"]
    assert content[odd]["taken"] == taken.to_dict() != {}
    torque = validate(bench, fit)[odd].channels["torque"]
    assert torque.residual_rms == pytest.approx(NOISE_NM, rel=0.1)


@pytest.mark.slow
def test_a_gain_that_is_off_is_found():
    """Truth: one record was multiplied by 0.9, the others by 1: the gain of each within 5 standard errors."""
    fit = identify(made("full_46", polarity=0.9), workers=1)
    gains = {name: p for name, p in fit.parameters.items() if name.endswith(".transducer.gain")}
    assert len(gains) == 3
    for name, p in gains.items():
        assert p.value == pytest.approx(0.9 if "full_46" in name else 1.0, abs=5.0 * p.std_error)
    within(fit)
    assert [one.name for one in fit.missing] == ["record.gain"]


@pytest.mark.slow
@pytest.mark.parametrize("limit", [as_written_only, lambda bench: bench])
def test_an_undeclared_time_offset_is_found_and_estimated(limit):
    """Truth: the record was shifted by 3 ms against its command; within 5 standard errors and 1 us."""
    bench = limit(made("full_46", late_s=LATE_S))
    fit = identify(bench, workers=1)
    p = fit.parameters["record.full_46.time_offset_s"]
    assert fit.outcome is FitOutcome.CONVERGED
    assert (p.status, p.value) == ("free", pytest.approx(LATE_S, abs=max(1e-6, 5.0 * p.std_error)))
    within(fit)
    assert [w for w in fit.warnings if w.startswith("record full_46:") and "time_offset_s = { value = 0.003" in w]
    torque = validate(bench, fit)["full_46"].channels["torque"]
    assert torque.residual_rms == pytest.approx(NOISE_NM, rel=0.1)


@pytest.mark.slow
def test_of_two_records_the_first_is_believed():
    """Truth: a quarter turn between two records; which of them was turned no torque tells."""
    free = displaced(truth(), dict.fromkeys((*FACTORS, *PHASES), 1.1))
    fit = identify(made("full_46", names=NAMES[::2], start=free, driven=lambda c: turned(c, 90.0)), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert fit.records["full_46"].reading == DECLARED
    assert fit.records["micro_46"].reading.start_angle_deg in (90.0, -90.0)


def test_records_that_agree_are_not_compared(monkeypatch):
    """Truth: records made as declared; nothing is said, and the comparison is not even begun."""

    def refused(*_, **__):
        raise AssertionError("the records agree")

    monkeypatch.setattr(reading_rungs, "agreement", refused)
    fit = identify(made(), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert {r.reading for r in fit.records.values()} == {DECLARED}
    assert not fit.warnings


def test_all_signs_reversed_is_only_noted():
    """Truth: the mirror image, torque, rate, start angle and detent phases of the other sign, is the same record."""
    start = displaced(truth({name: -truth().value(name) for name in PHASES}), FACTORS)
    mirrored = made(
        "all", start=start, driven=lambda c: replace(backward(c), start_angle_deg=-c.start_angle_deg), polarity=-1.0
    )
    fit = identify(mirrored, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    within(fit)
    assert not fit.warnings
    assert {r.reading for r in fit.records.values()} == {DECLARED}
    assert [n for n in fit.notes if "signs reverse together" in n]


@pytest.mark.slow
def test_a_record_of_another_mechanism_is_left_out():
    """Truth: the load of one record was another one; the others' mechanism is found without it."""
    bench = made("full_23", by=truth({"load.inertia": 0.03, "stepper.peak_voltage": 4.0}))
    fit = identify(bench, workers=1)
    own = fit.records["full_23"]
    assert fit.outcome is FitOutcome.HORIZON
    assert fit.grade is Grade.C
    assert (fit.reasons[0].cause, fit.reasons[0].record) == (Cause.LEFT_OUT, "full_23")
    assert fit.reasons[0].next_command.startswith("mechid check ")
    assert (own.reading, own.use) == (Reading(left_out=True), "validate")
    assert own.horizon_s < SECONDS
    within(fit)
    assert [w for w in fit.warnings if w.startswith("record full_23: left out")]
    assert validate(bench, fit)["full_23"].use == "validate"


@pytest.mark.slow
def test_a_sensor_that_bends_is_named():
    """Truth: the record passed a tanh, 32 % short at its largest torque; of a cubic nearest to it somewhat less."""
    bench = made("full_46", sensed=bending)
    fit = identify(bench, workers=1)
    assert fit.grade is Grade.C
    assert fit.records["full_46"].reading == Reading(left_out=True)
    within(fit)
    (said,) = (w for w in fit.warnings if w.startswith("record full_46: left out"))
    short, largest = re.search(
        r"the larger its torque, the more .* by (\S+) % at (\S+) N m, as where a transducer .* saturates", said
    ).groups()
    assert 20.0 < float(short) < 40.0
    y = torque_of(truth(), COMMANDS["full_46"], first_moments(make_problem(bench, 1).targets[0]))
    assert float(largest) == pytest.approx(np.abs(y).max(), rel=0.05)


def test_a_few_records_whose_noise_was_raised_are_compared_with_the_others():
    """Truth: a gain of 0.9 in one of three; from values near by, the others at their own noise tell it."""
    bench = made("micro_46", polarity=0.9)
    problem = make_problem(bench, 1)
    q = problem.coordinates.point({name: truth().value(name) for name in FACTORS})
    found = agreement_of_others(problem, ["micro_46"], q, 0)
    ((name, (_, reading)),) = found.scores.items()
    assert (name, found.left_out, found.growth.complete) == ("micro_46", {}, True)
    assert reading.reading.scale == pytest.approx(1.0 / 0.9, rel=5e-3)
