"""What a fit says of itself: bounds, what no record sees, validation, misfits, stages, interruptions."""

import json
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import Stage
from mechid.campaign.bench import TRUTH
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.identify_options import IdentifyOptions
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.prediction import simulate
from mechid.identification.conclude import ONE_RECORD
from mechid.identification.identify import identify, make_problem
from mechid.identification.result.grade import Cause, FitOutcome, Grade
from synthetic import AS_WRITTEN, COMMANDS, NOISE_NM, bench, bounded, campaign, displaced, measured, record, truth

GEAR = {"gear.stiffness": 1.25, "gear.damping": 0.6}
PHASE, AMPLITUDE = "stepper.detent.1.phase_deg", "stepper.detent.1.amplitude"
SHORT_S = 0.12


def within(fit, names, made_by, sigmas=5.0):
    """Assert that estimates lie within some of their standard errors of what made the records."""
    for name in names:
        p = fit.parameters[name]
        assert abs(p.value - made_by.value(name)) < sigmas * p.std_error, name


def numbers(fit):
    """Return all that a fit found, without how long it took."""
    content = fit.to_dict()
    del content["provenance"]
    for stage in content["stages"]:
        del stage["seconds"]
    return json.dumps(content, sort_keys=True)


@pytest.fixture(scope="module")
def two_records():
    return bench(displaced(truth(), GEAR), truth(), "full_46", "micro_46", seed=31, seconds=SHORT_S)


@pytest.fixture(scope="module")
def fit(two_records):
    return identify(two_records, workers=1)


def test_the_truth_is_found_beside_the_catalogue(fit):
    """Truth: the mechanism that made the records, within 5 standard errors."""
    assert fit.outcome is FitOutcome.CONVERGED
    assert (fit.grade, fit.reasons) == (Grade.A, ())
    within(fit, GEAR, truth())
    assert {r.horizon_s for r in fit.records.values()} == {SHORT_S}
    assert [r.residual_rms for r in fit.records.values()] == pytest.approx([NOISE_NM, NOISE_NM], rel=0.1)


def test_threads_change_no_number(two_records, fit):
    """Truth: the same fit, to the bit, by one thread and by two."""
    assert numbers(identify(two_records, workers=2)) == numbers(fit)


def test_another_seed_finds_the_same_optimum(two_records, fit):
    """Truth: the optimum is one; seeds differ in how it is reached."""
    other = identify(two_records, seed=5, workers=1)
    for name in GEAR:
        assert other.parameters[name].value == pytest.approx(fit.parameters[name].value, rel=1e-5)


@pytest.fixture(scope="module", params=[AS_WRITTEN, pytest.param(IdentifyOptions(), marks=pytest.mark.slow)])
def at_bound(request):
    """Return the fit of records whose stiffness lies ten standard errors above what the file allows."""
    start = bounded(displaced(truth(), GEAR), "gear.stiffness", max=910.0)
    made = bench(start, truth(), "full_46", "micro_46", seed=31, seconds=SHORT_S)
    return identify(replace(made, options=request.param), workers=1)


def test_a_parameter_at_its_bound_is_named_and_has_no_error(at_bound):
    """Truth: the file's bound, and estimate.json's contract."""
    p = at_bound.parameters["gear.stiffness"]
    assert p.value == pytest.approx(910.0, rel=1e-6)
    assert p.value <= 910.0
    assert (p.status, p.std_error, p.std_error_white, p.ci95) == ("at_bound", None, None, None)
    assert "bound" in p.reason
    assert [w for w in at_bound.warnings if w.startswith("gear.stiffness: at bound")]
    assert [n for n in at_bound.correlation_names if not at_bound.parameters[n].added] == ["gear.damping"]
    assert at_bound.parameters["gear.damping"].std_error > 0.0


def test_a_bound_that_excludes_the_truth_makes_the_grade_c(at_bound):
    """Truth: the stiffness that made the records lies ten standard errors above the bound."""
    assert at_bound.grade is Grade.C
    (reason,) = (r for r in at_bound.reasons if r.cause is Cause.BOUND_CONTRADICTED)
    assert reason.parameter == "gear.stiffness"
    assert "gear.stiffness is held at 910 N m/rad" in reason.text
    assert reason.next_command.endswith("with a wider range of gear.stiffness in the mechanism file")


UNSEEN_DEG = 12.345678901234567


@pytest.fixture(scope="module")
def unseen():
    """Return the fit of a mechanism whose second detent is known to be zero while its phase is free."""
    made_by = truth({AMPLITUDE: 0.0, PHASE: UNSEEN_DEG})
    start = displaced(made_by, {**GEAR, PHASE: 1.0})
    assert start.value(PHASE) == UNSEEN_DEG
    return identify(bench(start, made_by, "full_46", "micro_46", seed=32, seconds=SHORT_S), workers=1)


def test_what_no_record_sees_is_frozen_with_a_remedy(unseen):
    """Truth: the equations, in which the phase of no detent does not occur; the file's value stays to the bit."""
    p = unseen.parameters[PHASE]
    assert (p.status, p.value, p.std_error) == ("frozen", UNSEEN_DEG, None)
    assert unseen.mechanism.value(PHASE) == UNSEEN_DEG
    assert "add a record" in p.reason
    assert [w for w in unseen.warnings if w.startswith(f"{PHASE}: frozen") and "add a record" in w]
    assert unseen.correlation_names == tuple(GEAR)


def test_the_rest_is_estimated_beside_what_is_not_seen(unseen):
    """Truth: the mechanism that made the records."""
    assert unseen.outcome is FitOutcome.CONVERGED
    within(unseen, GEAR, truth({AMPLITUDE: 0.0}))


def test_a_record_at_rest_tells_nothing():
    """Truth: without step and detent nothing moves; every value stays the file's, to the bit."""
    still = replace(COMMANDS["full_46"], rate=replace(COMMANDS["full_46"].rate, rates=(0.0,)))
    quiet = truth({"stepper.detent.0.amplitude": 0.0, AMPLITUDE: 0.0})
    start = displaced(quiet, {"gear.stiffness": 1.1, "stepper.coil_resistance": 1.03})
    torque = measured(quiet, still, np.random.default_rng(33), seconds=0.1)
    found = identify(campaign(start, record("rest", torque, still)), workers=1)
    for name in ("gear.stiffness", "stepper.coil_resistance"):
        p = found.parameters[name]
        assert (p.status, p.value, p.std_error) == ("frozen", start.value(name), None)


@pytest.fixture(scope="module")
def validated(two_records):
    """Return a campaign whose second record is for validation, and its fit."""
    held = replace(two_records, records=(two_records.records[0], replace(two_records.records[1], use="validate")))
    return held, identify(held, workers=1)


def test_a_validation_record_does_not_touch_the_fit(two_records, validated):
    """Truth: the fit of the first record alone, to the bit."""
    _, fit = validated
    alone = identify(replace(two_records, records=two_records.records[:1]), workers=1)
    for name in GEAR:
        assert fit.parameters[name] == alone.parameters[name]
    assert fit.records["full_46"] == alone.records["full_46"]


def test_a_validation_record_is_predicted(validated):
    """Truth: the simulation at the estimate, its fit by numpy with offset and drift taken off."""
    held, fit = validated
    own, data = fit.records["micro_46"], held.record("micro_46").data
    y, time = data.channel("torque").data, np.arange(data.samples) / data.sample_rate_hz
    off = y - simulate(replace(held, mechanism=fit.mechanism), "micro_46").torque
    line = np.polynomial.Polynomial.fit(time, off, 1).convert()
    rest, spread = off - line(time), y - line(time)
    assert own.use == "validate"
    assert own.samples == data.samples
    assert own.residual_rms == pytest.approx(np.sqrt(np.mean(rest**2)), rel=1e-3)
    assert own.residual_rms == pytest.approx(NOISE_NM, rel=0.1)
    wanted = 100.0 * (1.0 - np.linalg.norm(rest) / np.linalg.norm(spread - spread.mean()))
    assert own.fit_percent == pytest.approx(wanted, abs=0.05)
    assert (own.offset, own.drift) == pytest.approx(tuple(line.coef), rel=1e-2, abs=1e-5)
    assert own.horizon_s == SHORT_S


@pytest.mark.slow
@pytest.mark.parametrize("options", [AS_WRITTEN, IdentifyOptions()])
def test_a_model_that_lacks_the_waveform_says_how_far_it_goes(options):
    """Truth: half steps driven by square waves; with cosines no value of the parameters follows them.

    No effect that may be added changes this.
    """
    half = replace(COMMANDS["full_23"], stepping="half", microsteps=2)
    torque = measured(truth(), replace(half, waveform="square"), np.random.default_rng(34), seconds=0.2)
    start = displaced(truth(), {"stepper.torque_constant": 1.1, "gear.stiffness": 1.1, "gear.damping": 0.8})
    fit = identify(replace(campaign(start, record("half_23", torque, half)), options=options), workers=1)
    own = fit.records["half_23"]
    assert fit.outcome is FitOutcome.HORIZON
    assert own.horizon_s < 0.1
    assert fit.grade is Grade.C
    assert [(r.cause, r.record) for r in fit.reasons[:1]] == [(Cause.USED_IN_PART, "half_23")]
    assert fit.reasons[0].instant_s == pytest.approx(own.horizon_s, abs=0.01)
    assert "the command runs at 23 steps/s there" in fit.reasons[0].text
    assert fit.reasons[0].next_command.startswith("mechid identify ")
    assert fit.notes[-1] == ONE_RECORD
    assert [w for w in fit.warnings if "half_23" in w and "s of 0.2 s; the command runs at 23 steps/s there" in w]
    assert [w for w in fit.warnings if w.startswith("all records: 100 %") and 'waveform = "square"' in w]


@pytest.mark.slow
def test_a_model_that_lacks_a_detent_follows_at_a_raised_noise_level_and_says_so():
    """Truth: a third detent, of 7.2 deg, made the record; the model has the other two, free, and the gear.

    Terms beside, which would find it, are switched off.
    """
    third = deepcopy(dict(CATALOGUE))
    third["stepper"]["detent"].append({"period_deg": 7.2, "amplitude": 0.03, "phase_deg": 60.0})
    made_by = mechanism_from_table(third, "third detent").with_values(TRUTH)
    torque = measured(made_by, COMMANDS["full_23"], np.random.default_rng(37), seconds=0.4)
    names = [n for n in TRUTH if n.startswith(("stepper.detent", "gear"))]
    start = displaced(truth(), dict.fromkeys(names, 1.1))
    made = campaign(start, record("full_23", torque, COMMANDS["full_23"]))
    fit = identify(replace(made, options=IdentifyOptions(terms=False)), workers=1)
    own = fit.records["full_23"]
    assert fit.outcome is FitOutcome.CONVERGED
    assert (own.noise_rests_on, own.horizon_s) == ("residual", pytest.approx(0.4, abs=1e-3))
    assert own.noise_known == pytest.approx(NOISE_NM, rel=0.1)
    assert NOISE_NM < own.noise_sigma < 0.1 * np.std(torque)
    stiffness = fit.parameters["gear.stiffness"]
    assert abs(stiffness.value - TRUTH["gear.stiffness"]) < 5.0 * stiffness.std_error
    (said,) = (w for w in fit.warnings if w.startswith("record full_23: to follow it the noise level was raised"))
    assert "at its initial level the model follows it for 0.0" in said
    assert "the command runs at 23 steps/s there" in said
    assert "the misfit around" in said


MOVED, HELD = ("gear.stiffness", "gear.damping", "stepper.coil_resistance"), "stepper.torque_constant"


@pytest.fixture(scope="module")
def staged():
    """Return a campaign of two stages, the gear on one record and then the coil with it on both, and its fit."""
    stages = (
        Stage(records=("full_46",), window_s=(0.0, 0.1), free=("gear.stiffness", "gear.damping")),
        Stage(records=("full_46", "micro_46"), window_s=None, free=MOVED),
    )
    factors = {"gear.stiffness": 1.01, "gear.damping": 0.9, "stepper.coil_resistance": 1.02, HELD: 1.0}
    start = displaced(truth(), factors)
    made = bench(start, truth(), "full_46", "micro_46", seed=35, seconds=SHORT_S, stages=stages)
    return made, identify(made, workers=1)


def test_stages_come_to_the_truth_one_after_the_other(staged):
    """Truth: the mechanism that made the records; every parameter that a stage moved is estimated."""
    made, fit = staged
    assert fit.outcome is FitOutcome.STAGES_DONE
    assert fit.grade is Grade.A
    assert [s.free for s in fit.stages] == [s.free for s in made.stages]
    assert [dict(s.records) for s in fit.stages] == [{"full_46": 0.1}, {"full_46": SHORT_S, "micro_46": SHORT_S}]
    within(fit, MOVED, truth())
    assert set(fit.correlation_names) == set(MOVED)


def test_what_is_in_no_stage_stays_as_it_was(staged):
    """Truth: the file."""
    made, fit = staged
    p = fit.parameters[HELD]
    assert (p.status, p.value, p.std_error) == ("frozen", made.mechanism.value(HELD), None)
    assert "no stage" in p.reason


def test_a_time_offset_is_found_in_a_stage():
    """Truth: the record starts 0.7 ms before its command; within 5 standard errors and 1 us."""
    late = 7e-4
    y = measured(truth(), COMMANDS["full_46"], np.random.default_rng(36), seconds=SHORT_S, time_offset_s=late)
    own = record("full_46", y, COMMANDS["full_46"], time_offset={"value": 0.0, "min": -2e-3, "max": 2e-3})
    name = "record.full_46.time_offset_s"
    stage = Stage(records=("full_46",), window_s=None, free=("gear.stiffness", name))
    start = displaced(truth(), {"gear.stiffness": 1.002})
    fit = identify(campaign(start, own, stages=(stage,)), workers=1)
    assert fit.parameters[name].value == pytest.approx(late, abs=max(1e-6, 5.0 * fit.parameters[name].std_error))


def interrupt_in(number):
    """Return a listener that interrupts at the first report of a stage."""

    def listen(progress):
        if progress.number == number:
            raise KeyboardInterrupt

    return listen


def cost(made, values):
    """Return the sum of squares over all records, in sigmas, at some of the file's values."""
    problem = make_problem(made, 1)
    mechanism = made.mechanism.with_values(values)
    q = problem.space.from_values({name: mechanism.value(name) for name in mechanism.parameters})
    return sum(norm**2 for norm in problem.norms(q, problem.whole_windows()))


@pytest.mark.parametrize("number", [1, 2, 4])
def test_ctrl_c_keeps_the_best_so_far(two_records, fit, number):
    """Truth: the outcome; from the growth on no worse a cost than the file's, from the joint fit on the optimum's."""
    stopped = identify(two_records, workers=1, listener=interrupt_in(number))
    assert stopped.outcome is FitOutcome.INTERRUPTED
    assert stopped.grade is Grade.FAILED
    assert [r.cause for r in stopped.reasons] == [Cause.INTERRUPTED]
    assert all(p.std_error is None for p in stopped.parameters.values())
    assert len(stopped.stages) == number - 1
    assert json.loads(json.dumps(stopped.to_dict()))["outcome"]["code"] == "interrupted"
    best, found = ({name: f.parameters[name].value for name in GEAR} for f in (fit, stopped))
    start = {name: two_records.mechanism.value(name) for name in GEAR}
    assert cost(two_records, best) - 0.01 < cost(two_records, found) <= cost(two_records, start) * (1.0 + 1e-9)
    if number == 1:
        assert found == pytest.approx(start, rel=1e-9)
    if number == 4:
        assert cost(two_records, found) < cost(two_records, best) + 1.0


def test_ctrl_c_in_a_stage_keeps_that_of_the_stages_before(staged):
    """Truth: what the first stage found alone; nothing moved yet in the second."""
    made, _ = staged
    first = identify(replace(made, stages=made.stages[:1]), workers=1)
    stopped = identify(made, workers=1, listener=interrupt_in(2))
    assert stopped.outcome is FitOutcome.INTERRUPTED
    for name in ("gear.stiffness", "gear.damping"):
        assert stopped.parameters[name].value == pytest.approx(first.parameters[name].value, rel=1e-9)
    coil = stopped.parameters["stepper.coil_resistance"]
    assert (coil.value, coil.status) == (pytest.approx(made.mechanism.value(coil.name), rel=1e-9), "free")
