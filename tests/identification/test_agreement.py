"""Records that are not as declared: found by what the others agree on, taken or left out; or common to all."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.validation import validate
from mechid.command import Command, RateProfile
from mechid.command.stepping import MOST_MICROSTEPS
from mechid.identification.contradiction.agreement import agreement_without
from mechid.identification.contradiction.alternatives import first_moments, judge, steppings, turns_deg
from mechid.identification.contradiction.bent_sensor import bend_words
from mechid.identification.contradiction.common_reading import common_readings
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED, Reading, command_as_read
from mechid.identification.result.grade import Cause, Grade
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.search.gates import Growth
from mechid.identification.stages import growth
from synthetic import (
    COMMANDS,
    NOISE_NM,
    RATE_HZ,
    campaign,
    displaced,
    measured,
    measuring,
    record,
    torque_of,
    truth,
)

FACTORS = {"gear.stiffness": 1.25, "gear.damping": 0.6, "stepper.torque_constant": 0.9}
NAMES = ("full_46", "full_23", "micro_46")
SECONDS = 0.15
LATE_S = 3e-3
PHASES = ("stepper.detent.0.phase_deg", "stepper.detent.1.phase_deg")


def backward(command):
    """Return a command with its rate of the other sign."""
    return replace(command, rate=RateProfile.constant(-command.rate.rates[0]))


def turned(command, turn_deg):
    """Return a command from another start angle."""
    return replace(command, start_angle_deg=command.start_angle_deg + turn_deg)


def half_steps(command):
    """Return a command in half steps at the same rate."""
    return replace(command, stepping="half", microsteps=2)


def made(
    odd=None,
    *,
    names=NAMES,
    start=None,
    driven=lambda c: c,
    polarity=1.0,
    late_s=0.0,
    by=None,
    sensed=lambda y: y,
    seed=61,
):
    """Return a campaign whose record `odd` (or all, where that is "all") was not made as it is declared."""
    rng = np.random.default_rng(seed)
    records = []
    for name in names:
        is_odd = odd in (name, "all")
        command = driven(COMMANDS[name]) if is_odd else COMMANDS[name]
        maker = by if is_odd and by else truth()
        y = measured(maker, command, rng, seconds=SECONDS, time_offset_s=late_s if is_odd else 0.0)
        records.append(record(name, sensed(polarity * y) if is_odd else y, COMMANDS[name]))
    return campaign(start or displaced(truth(), FACTORS), *records)


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


@pytest.mark.parametrize(
    ("stepping", "microsteps", "tried"),
    [
        ("full", 1, [("half", 2, 46.0), ("half", 2, 23.0)]),
        ("half", 2, [("micro", 4, 46.0), ("micro", 4, 23.0), ("full", 1, 46.0), ("full", 1, 92.0)]),
        ("micro", 5, [("micro", 10, 46.0), ("micro", 10, 23.0)]),
        ("micro", MOST_MICROSTEPS, [("micro", 32768, 46.0), ("micro", 32768, 92.0)]),
    ],
)
def test_steps_may_be_twice_or_half_as_many(stepping, microsteps, tried):
    """Truth: by hand, at the declared rate and with the declared pulses; each is a command that can be."""
    command = Command(stepping=stepping, microsteps=microsteps, rate=RateProfile.constant(46.0))
    read = [command_as_read(command, taken) for taken in steppings(command)]
    assert [(c.stepping, c.microsteps, c.rate.rates[0]) for c in read] == tried


QUICK = ("direction", "quarter turn")


@pytest.mark.parametrize("case", [c if c in QUICK else pytest.param(c, marks=pytest.mark.slow) for c in CASES])
def test_a_record_that_contradicts_the_others_is_taken_as_it_was(case):
    """Truth: how the record was made, and the mechanism that made all."""
    odd, how, taken = CASES[case]
    bench = made(odd, **how)
    fit = identify(bench, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert {name: r.taken for name, r in fit.records.items()} == {**dict.fromkeys(NAMES, DECLARED), odd: taken}
    within(fit)
    (said,) = (w for w in fit.warnings if w.startswith(f"record {odd}:"))
    assert "declared" in said
    assert "write" in said
    content = json.loads(json.dumps(fit.to_dict()))["records"]
    assert content[odd]["taken"] == taken.to_dict() != {}
    torque = validate(bench, fit)[odd].channels["torque"]
    assert torque.residual_rms == pytest.approx(NOISE_NM, rel=0.1)


def test_a_gain_that_is_off_is_found():
    """Truth: one record was multiplied by 0.9; what is left of its gain the fit may put beside it."""
    bench = made("full_46", polarity=0.9)
    fit = identify(bench, workers=1)
    taken = fit.records["full_46"].taken
    assert taken.scale == pytest.approx(1.0 / 0.9, rel=2e-3)
    assert taken.changes == 1
    within(fit)
    assert [w for w in fit.warnings if w.startswith("record full_46:") and "torque times 1.1" in w and "gain" in w]


def test_an_undeclared_time_offset_is_found_and_estimated():
    """Truth: the record was shifted by 3 ms against its command; within 5 standard errors and 1 us."""
    bench = made("full_46", late_s=LATE_S)
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
    assert fit.records["full_46"].taken == DECLARED
    assert fit.records["micro_46"].taken.start_angle_deg in (90.0, -90.0)


def test_records_that_agree_are_not_compared(monkeypatch):
    """Truth: records made as declared; nothing is said, and the comparison is not even begun."""

    def refused(*_, **__):
        raise AssertionError("the records agree")

    monkeypatch.setattr(growth, "agreement", refused)
    fit = identify(made(), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert {r.taken for r in fit.records.values()} == {DECLARED}
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
    assert {r.taken for r in fit.records.values()} == {DECLARED}
    assert [n for n in fit.notes if "all signs" in n and "reversed" in n]


@pytest.mark.parametrize(("late_s", "told"), [(5e-3, True), (-3e-3, True), (2e-4, False)])
def test_commands_that_begin_late_in_all_records_are_told(late_s, told):
    """Truth: the time offset that made them; one as short is what a filter does, and is looked for as such."""
    problem = make_problem(made("all", late_s=late_s), 1)
    stuck = Growth(problem.start, dict.fromkeys(NAMES, 100), False, 0)
    lines = [r.line for r in common_readings(problem, stuck, 1) if "time_offset_s" in r.line]
    assert len(lines) == told
    if told:
        assert float(re.search(r"time_offset_s = (\S+) for each", lines[0])[1]) == pytest.approx(late_s, rel=0.01)
        assert lines[0].startswith("all records: 100 % of their samples are followed with their commands")


@pytest.mark.slow
def test_one_sign_of_all_records_is_told_and_not_taken():
    """Truth: all torques of the other sign under the commands as declared; which of the two it is no record tells."""
    fit = identify(made("all", polarity=-1.0), workers=1)
    assert fit.outcome is FitOutcome.HORIZON
    assert {r.taken for r in fit.records.values()} == {DECLARED}
    assert [w for w in fit.warnings if w.startswith("all records: 100 %") and "gain = -1.0" in w]


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
    assert (own.taken, own.use) == (Reading(left_out=True), "validate")
    assert own.horizon_s < SECONDS
    within(fit)
    assert [w for w in fit.warnings if w.startswith("record full_23: left out")]
    assert validate(bench, fit)["full_23"].use == "validate"


def bending(y):
    """Return what a transducer gives that comes to 0.8 of the largest torque at most."""
    most = 0.8 * np.abs(y).max()
    return most * np.tanh(y / most)


@pytest.mark.slow
def test_a_sensor_that_bends_is_named():
    """Truth: the record passed a tanh, 32 % short at its largest torque; of a cubic nearest to it somewhat less."""
    bench = made("full_46", sensed=bending)
    fit = identify(bench, workers=1)
    assert fit.grade is Grade.C
    assert fit.records["full_46"].taken == Reading(left_out=True)
    within(fit)
    (said,) = (w for w in fit.warnings if w.startswith("record full_46: left out"))
    short, largest = re.search(
        r"the larger its torque, the more .* by (\S+) % at (\S+) N m, as where a transducer .* saturates", said
    ).groups()
    assert 20.0 < float(short) < 40.0
    y = torque_of(truth(), COMMANDS["full_46"], first_moments(make_problem(bench, 1).targets[0]))
    assert float(largest) == pytest.approx(np.abs(y).max(), rel=0.05)


def test_a_record_of_another_mechanism_does_not_bend():
    """Truth: another load made it, no transducer; the words of a sensor that saturates are not used."""
    other = torque_of(truth({"load.inertia": 0.03}), COMMANDS["full_46"], round(SECONDS * RATE_HZ) + 1)
    problem = make_problem(made(start=truth()), 1)
    target = measuring(problem.targets[0], other)
    assert bend_words(problem, problem.start, target) == ""
    bent = measuring(problem.targets[0], bending(problem.targets[0].leading.measured[:]))
    assert "saturates" in bend_words(problem, problem.start, bent)


SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (1.5, 90.0)]))


def test_a_gain_is_looked_for_beyond_the_first_moments():
    """Truth: a sweep times 0.9, of which the first moments are small; the gain is found over all of it."""
    rng = np.random.default_rng(7)
    y = measured(truth(), SWEEP, rng, seconds=1.5)
    problem = make_problem(campaign(truth(), record("sweep", 0.9 * y, SWEEP)), 1)
    target = problem.targets[0]
    declared, found, *_ = judge(problem, problem.start, target, target.samples)
    assert not declared.follows
    assert found.follows
    assert found.taken.scale == pytest.approx(1.0 / 0.9, rel=1e-3)
    assert found.samples == target.samples


def test_a_few_records_whose_noise_was_raised_are_compared_with_the_others():
    """Truth: a gain of 0.9 in one of three; from values near by, the others at their own noise tell it."""
    bench = made("micro_46", polarity=0.9)
    problem = make_problem(bench, 1)
    q = problem.coordinates.point({name: truth().value(name) for name in FACTORS})
    found = agreement_without(problem, ["micro_46"], q, 0)
    ((name, (_, reading)),) = found.judged.items()
    assert (name, found.left_out, found.growth.complete) == ("micro_46", {}, True)
    assert reading.taken.scale == pytest.approx(1.0 / 0.9, rel=5e-3)


def test_turns_that_no_torque_shows_are_not_tried():
    """Truth: orders 4 and 2 come again after half an electrical turn, 4 alone after a quarter, 1 after a whole one."""
    full, micro = COMMANDS["full_46"], COMMANDS["micro_46"]
    assert turns_deg(full, (4.0, 2.0)) == (0.0, 45.0, -45.0, 90.0)
    assert turns_deg(full, (4.0,)) == (0.0, 45.0)
    assert turns_deg(full, (4.0, 1.0)) == (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
    assert len(turns_deg(micro, (4.0, 2.0))) == 32
    assert turns_deg(micro, ()) == (0.0,)


def test_a_command_taken_backward_runs_backward():
    """Truth: the command's own edges, of which the other direction has the mirror image."""
    command = COMMANDS["full_46"]
    there, back = command.excitation(0.1), command_as_read(command, Reading(direction=-1)).excitation(0.1)
    np.testing.assert_array_equal(there.times, back.times)
    np.testing.assert_allclose(there.values[0], [1, 1] * np.sqrt(np.array([0.5, 0.5])), atol=1e-12)
    np.testing.assert_allclose(back.values[0], [-1, -1] * np.sqrt(np.array([0.5, 0.5])), atol=1e-12)
