"""The grade of a fit. Truth: fits made by hand, each with one thing wrong and known."""

from dataclasses import replace

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from mechid.campaign import catalogue_mechanism
from mechid.identification.grading import Evidence, grade_fit
from mechid.identification.output_error.declaration import Reading
from mechid.identification.result.grade import (
    Cause,
    Consistency,
    FitOutcome,
    Grade,
    Scatter,
)
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.record_result import ChannelFit, MaskedMoment, RecordFit

EVENT = "the model's friction goes from stuck to forward"
FACTORS = {"gear.stiffness": 2.0, "gear.damping": 6.0, "friction.coulomb": 3.0}
"""By which the standard errors of the free parameters exceed those of noise."""


def parameter(name, factor=None, **changes):
    noise = None if factor is None else 0.1
    entries = {
        "symbol": "x",
        "unit": "N*m",
        "value": 2.0,
        "std_error": factor and factor * 0.1,
        "std_error_noise": noise,
        "std_error_white": noise,
        "start": 1.0,
        "min": 0.0,
        "max": 2.0,
        "status": "free" if factor else "at_bound",
    }
    return ParameterEstimate(name=name, **(entries | changes))


def record(name, *, use="estimate", taken=None, **changes):
    channel = ChannelFit(
        unit="N*m", use=use, fit_percent=99.0, residual_rms=2e-3, noise_sigma=2e-3, offset=0.0, drift=0.0, **changes
    )
    return RecordFit(
        name=name,
        use=use,
        samples=1001,
        fit_percent=99.0,
        residual_rms=2e-3,
        noise_sigma=2e-3,
        offset=0.0,
        drift=0.0,
        horizon_s=1.0,
        channels={"torque": channel},
        reading=taken or Reading(),
    )


def fit(*records, outcome=FitOutcome.CONVERGED, consistency=None, parameters=()):
    free = [parameter(name, factor) for name, factor in FACTORS.items()]
    return fit_by_hand(
        catalogue_mechanism(),
        parameters={p.name: p for p in (*free, *parameters)},
        correlation_names=tuple(FACTORS),
        correlation=np.eye(3),
        covariance=np.eye(3),
        records={r.name: r for r in records or (record("full"), record("sweep"))},
        outcome=outcome,
        consistency=consistency,
    )


EVIDENCE = Evidence(
    campaign="bench",
    used=("full", "sweep", "fast"),
    used_to_s={},
    predicted_reduction=0.0,
    cost=2000.0,
    lost=False,
    contradicted={},
    circumstances=lambda *_: EVENT,
    seed=4,
)
AGAIN = "mechid identify bench --out DIR --seed 5"


def only(found):
    """Return the one reason of a fit."""
    (reason,) = found.reasons
    return reason


def test_a_fit_with_nothing_against_it_is_complete():
    parts = Consistency(phase=Scatter(ratio=1.1, z=3.9, clusters=32), record=Scatter(ratio=1.0, z=0.1, clusters=2))
    found = grade_fit(fit(consistency=parts), EVIDENCE)
    assert (found.grade, found.reasons) == (Grade.A, ())


def test_a_value_that_the_records_contradict_is_the_first_reason():
    """Truth: the evidence; a bound that is contradicted as well comes behind it."""
    said = {"load.inertia": "With the file no start explains the records."}
    held = replace(parameter("gear.stiffness"), contradicted=True)
    found = grade_fit(fit(parameters=(held,)), replace(EVIDENCE, contradicted=said))
    first, *others = found.reasons
    assert (found.grade, first.cause, first.parameter) == (Grade.C, Cause.VALUE_CONTRADICTED, "load.inertia")
    assert first.text == said["load.inertia"]
    assert first.next_command.endswith("with the right unit, value or bounds of load.inertia in the mechanism file")
    assert [reason.cause for reason in others] == [Cause.BOUND_CONTRADICTED]


def test_a_bound_that_the_records_allow_is_nothing_against_it():
    assert grade_fit(fit(parameters=(parameter("load.inertia"),)), EVIDENCE).grade is Grade.A


def test_parts_that_disagree_are_model_error_and_the_widening_is_said():
    """Truth: standard errors 2, 6 and 3 times those of noise: 6 at most, 3 in the median."""
    parts = Consistency(
        phase=Scatter(ratio=8.4, z=131.0, clusters=32),
        time=Scatter(ratio=1.0, z=0.3, clusters=10),
        parameter="gear.damping",
        contested_record="sweep",
    )
    found = grade_fit(fit(consistency=parts), EVIDENCE)
    reason = only(found)
    assert found.grade is Grade.B
    assert (reason.cause, reason.parameter, reason.record) == (Cause.PARTS_DISAGREE, "gear.damping", "sweep")
    assert (reason.widened_most, reason.widened_median) == pytest.approx((6.0, 3.0))
    for words in (
        "between the phases of a step 8.4 times",
        "gear.damping and record sweep",
        "by 6 at most and by 3 in",
    ):
        assert words in reason.text
    assert "stretches" not in reason.text


def test_an_optimum_at_a_threshold_is_b_and_says_what_was_promised():
    found = grade_fit(fit(outcome=FitOutcome.CLIFF), replace(EVIDENCE, predicted_reduction=12.0))
    assert (found.grade, only(found).cause, only(found).next_command) == (Grade.B, Cause.THRESHOLD, AGAIN)
    assert "a fall of the cost by 12" in only(found).text


@pytest.mark.parametrize(("value", "named"), [(1.9999, True), (1.99, False), (1e-5, False)])
def test_a_bound_close_to_which_a_fit_stopped_short_is_named(value, named):
    """Truth: a range from 0 to 2; at 0 most values have a limit of physics, not of the file."""
    close = parameter("stepper.torque_constant", 1.0, value=value)
    found = grade_fit(
        fit(outcome=FitOutcome.CLIFF, parameters=(close,)),
        replace(EVIDENCE, predicted_reduction=12.0),
    )
    said = "stepper.torque_constant = 1.9999 is at its bound 2" in only(found).text
    assert said is named
    assert ("stepper.torque_constant" in only(found).text) is named


@pytest.mark.parametrize(
    ("fall", "grade", "causes"),
    [(0.5, Grade.A, []), (150.0, Grade.B, [Cause.NEAR_OPTIMUM]), (300.0, Grade.C, [Cause.NOT_CONVERGED])],
)
def test_a_limit_of_steps_counts_by_what_is_still_promised(fall, grade, causes):
    """Of a cost of 2000; a fall below 1 moves nothing by more than its error."""
    found = grade_fit(fit(outcome=FitOutcome.NOT_CONVERGED), replace(EVIDENCE, predicted_reduction=fall))
    assert (found.grade, [r.cause for r in found.reasons]) == (grade, causes)


def test_a_moment_left_out_is_b():
    """Truth: the moment by hand."""
    moment = MaskedMoment(first=20, stop=30, from_s=2.0, to_s=3.0, largest=0.5, over_noise=70.0, chi_square=4900.0)
    found = grade_fit(fit(record("full", masked=(moment,)), record("sweep")), EVIDENCE)
    assert (found.grade, only(found).cause) == (Grade.B, Cause.MASKED)
    assert (only(found).record, only(found).instant_s) == ("full", 2.0)


def test_an_event_missed_for_less_than_a_window_is_b():
    found = grade_fit(fit(outcome=FitOutcome.EVENT_MISSED), EVIDENCE)
    assert (found.grade, only(found).cause) == (Grade.B, Cause.EVENT_MISSED)


@pytest.mark.parametrize(("over", "grade"), [(0.4, Grade.B), (1.1, Grade.A), (5.0, Grade.B)])
def test_one_record_without_steps_is_complete_only_down_to_its_noise(over, grade):
    """Truth: its residual beside its noise; parts of it are compared over time alone."""
    own = record("full")
    channel = replace(own.channels["torque"], residual_rms=over * 2e-3)
    own = replace(own, channels={"torque": channel})
    alone = Consistency(time=Scatter(ratio=1.0, z=0.2, clusters=10))
    assert grade_fit(fit(own, consistency=alone), EVIDENCE).grade is grade
    steps = replace(alone, phase=Scatter(ratio=1.0, z=0.2, clusters=32))
    assert grade_fit(fit(own, consistency=steps), EVIDENCE).grade is Grade.A


def test_a_record_that_is_not_followed_is_c_with_instant_cause_and_command():
    found = grade_fit(fit(record("full"), record("sweep", lost_at_s=0.85, followed_percent=97.5)), EVIDENCE)
    reason = only(found)
    assert found.grade is Grade.C
    assert (reason.cause, reason.record, reason.instant_s) == (Cause.NOT_FOLLOWED, "sweep", 0.85)
    assert reason.text == f"Record sweep is not followed at 0.85 s, and over 2.5 % of it in total: {EVENT}."
    assert reason.next_command.startswith("mechid diagnose ")


def test_a_motor_out_of_step_is_c_also_where_the_residual_is_small_beside_the_travel():
    found = grade_fit(fit(record("fast", out_of_step_at_s=3.1)), EVIDENCE)
    assert (found.grade, only(found).cause, only(found).instant_s) == (Grade.C, Cause.OUT_OF_STEP, 3.1)


def test_a_record_used_in_part_is_c():
    found = grade_fit(fit(outcome=FitOutcome.HORIZON), replace(EVIDENCE, used_to_s={"sweep": 0.21}))
    reason = only(found)
    assert (found.grade, reason.cause, reason.record, reason.instant_s) == (Grade.C, Cause.USED_IN_PART, "sweep", 0.21)
    assert reason.next_command == AGAIN


def test_a_record_left_out_is_c():
    left = record("sweep", use="validate", taken=Reading(left_out=True), lost_at_s=0.1)
    found = grade_fit(fit(record("full"), left, outcome=FitOutcome.HORIZON), EVIDENCE)
    assert (found.grade, only(found).cause, only(found).record) == (Grade.C, Cause.LEFT_OUT, "sweep")


def test_a_record_held_out_that_is_not_followed_takes_nothing_from_the_fit():
    held_out = fit(record("full"), record("other", use="validate", lost_at_s=0.1))
    assert grade_fit(held_out, EVIDENCE).grade is Grade.A


def test_a_record_in_no_stage_takes_nothing_from_the_fit():
    assert grade_fit(fit(record("full"), record("other", lost_at_s=0.1)), EVIDENCE).grade is Grade.A


@pytest.mark.parametrize(
    ("most", "remedy"), [(2.0, "with a wider range of friction.static"), (5.0, "another friction")]
)
def test_a_contradicted_bound_is_c(most, remedy):
    """The second lies on what it is never below, which is no bound of the file."""
    held = parameter("friction.static", max=most, contradicted=True, reason="the records want it 9 sigma beyond")
    found = grade_fit(fit(parameters=(held,)), EVIDENCE)
    assert (found.grade, only(found).cause, only(found).parameter) == (Grade.C, Cause.BOUND_CONTRADICTED, held.name)
    assert remedy in only(found).next_command


@pytest.mark.parametrize(
    ("name", "like"),
    [
        ("gear.damping", "backlash or hysteresis"),
        ("friction.viscous", "another law of friction"),
        ("motor.inertia", ""),
    ],
)
def test_a_limit_of_physics_is_b_with_its_interval_and_a_remedy_of_its_own(name, like):
    """No wider range mends a damping at 0, and a law of friction is no remedy of a gear."""
    held = parameter(
        name, value=2e-13, min=0.0, max=50.0, unit="N m s/rad", reason="6.7 beyond", at_physical_limit=True,
        one_sided=(0.0, 0.21),
    )  # fmt: skip
    found = grade_fit(fit(parameters=(held,)), EVIDENCE)
    reason = only(found)
    assert (found.grade, reason.cause, reason.parameter) == (Grade.B, Cause.PHYSICAL_LIMIT, name)
    assert f"{name} is held at 0 N m s/rad" in reason.text
    assert "one-sided, 0 to 0.21 N m s/rad" in reason.text
    assert like in reason.text
    assert ("friction" in reason.text.removeprefix(name)) is name.startswith("friction")
    assert reason.next_command.startswith("mechid diagnose ")


@pytest.mark.parametrize("over", [0.4, 5.0])
def test_what_is_unexplained_is_diagnosed_and_a_level_too_high_corrected(over):
    own = record("full")
    own = replace(own, channels={"torque": replace(own.channels["torque"], residual_rms=over * 2e-3)})
    command = only(grade_fit(fit(own), EVIDENCE)).next_command
    assert command.startswith("mechid diagnose ") is (over > 1.0)
    assert ("the right noise_sigma of record full" in command) is (over < 1.0)


@pytest.mark.parametrize(
    ("outcome", "lost", "cause"),
    [
        (FitOutcome.FAILED, False, Cause.NOT_SIMULATED),
        (FitOutcome.CONVERGED, True, Cause.NOT_SIMULATED),
        (FitOutcome.INTERRUPTED, False, Cause.INTERRUPTED),
    ],
)
def test_without_a_simulation_or_an_end_it_has_failed(outcome, lost, cause):
    found = grade_fit(fit(record("full", lost_at_s=0.1), outcome=outcome), replace(EVIDENCE, lost=lost))
    assert (found.grade, only(found).cause) == (Grade.FAILED, cause)


def held_out(residual_over_noise, fit_percent):
    """Return a held-out record of which a fit leaves so much."""
    own = record("half", use="validate")
    rms = residual_over_noise * own.noise_sigma
    channel = replace(own.channels["torque"], residual_rms=rms, fit_percent=fit_percent)
    return replace(own, residual_rms=rms, fit_percent=fit_percent, channels={"torque": channel})


@pytest.mark.parametrize(
    ("over_noise", "fit_percent", "grade", "cause"),
    [
        (1.06, 98.0, Grade.A, None),
        (1.9, 97.0, Grade.A, None),
        (2.1, 96.0, Grade.B, Cause.HELD_OUT),
        (25.0, 51.0, Grade.B, Cause.HELD_OUT),
        (25.0, 49.0, Grade.C, Cause.HELD_OUT_LOST),
        (np.nan, np.nan, Grade.C, Cause.HELD_OUT_LOST),
        (1.5, 20.0, Grade.A, None),  # a record that is mostly noise
    ],
)
def test_a_held_out_record_predicted_far_worse_than_its_noise_is_a_reason(over_noise, fit_percent, grade, cause):
    found = grade_fit(fit(record("full"), record("sweep"), held_out(over_noise, fit_percent)), EVIDENCE)
    assert found.grade is grade
    assert [reason.cause for reason in found.reasons] == ([cause] if cause else [])
    if cause and np.isfinite(over_noise):
        text = only(found).text
        assert f"its residual is {over_noise:.3g} times its noise, that of fitted records at most 1 times" in text
        assert (f"{100.0 - fit_percent:.3g} % of the measured signal" in text) is (grade is Grade.C)


def test_a_held_out_record_no_worse_than_the_fitted_ones_is_no_reason_of_its_own():
    """Truth: what is missing leaves three times the noise of a fitted record, and four of the one held out."""
    own = record("full")
    channel = replace(own.channels["torque"], residual_rms=3.0 * own.noise_sigma)
    worse = replace(own, residual_rms=channel.residual_rms, channels={"torque": channel})
    found = grade_fit(fit(worse, held_out(4.0, 90.0)), EVIDENCE)
    assert [reason.cause for reason in found.reasons] == [Cause.UNEXPLAINED]
    found = grade_fit(fit(worse, held_out(6.1, 90.0)), EVIDENCE)
    assert [reason.cause for reason in found.reasons] == [Cause.HELD_OUT, Cause.UNEXPLAINED]


def louder(name, over_known):
    """Return a fitted record that is followed at a level raised to so many times the noise known beforehand."""
    own = record(name)
    rms = over_known * own.noise_sigma
    raised = replace(own.channels["torque"], residual_rms=rms, noise_sigma=rms, noise_known=own.noise_sigma)
    return replace(own, residual_rms=rms, noise_sigma=rms, channels={"torque": replace(raised, worst_at_s=0.45)})


@pytest.mark.parametrize(("over", "others", "named"), [(4.7, 1.0, True), (1.9, 1.0, False), (5.0, 3.0, False)])
def test_one_record_far_louder_than_the_others_is_b_and_says_where(over, others, named):
    """Truth: a knock of 0.1 s in one of the records, which a raised noise level hides; or what is missing in all."""
    found = grade_fit(fit(louder("full", over), louder("sweep", others), louder("fast", others)), EVIDENCE)
    said = [reason for reason in found.reasons if "that of the other records" in reason.text]
    assert [reason.record for reason in said] == (["full"] if named else [])
    if named:
        assert found.grade is Grade.B
        assert "the residual is 4.7 times its noise" in said[0].text
        assert said[0].instant_s == 0.45
