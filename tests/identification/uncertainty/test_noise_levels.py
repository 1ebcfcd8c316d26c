"""Noise levels that nobody declared: what is known of them, raised where growth stalls, released to the residual."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from channels import written
from coloured import FREE, assert_true, coloured
from freed import assert_found
from layouts import mechanism_of, paper_table
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.noise_level import LARGEST, NoiseSource, known_noise
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.grade import FitOutcome, Grade
from mechid.identification.result.record_fit import channel_noises
from mechid.identification.search.gates import Growth
from mechid.identification.uncertainty.noise_levels import copy_levels, lower_levels, moving_deviation, raise_levels
from mechid.identification.uncertainty.settings import NOISE
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, bench, campaign, displaced, measured, truth
from synthetic import record as record_of

STEPS_OF = 0.05
ROUNDED = STEPS_OF / math.sqrt(12.0)
KINDS = {
    "declared": ({"noise_sigma": 0.01}, 0.01, NoiseSource.DECLARED),
    "declared below the resolution": (
        {"noise_sigma": 1e-9, "quantisation": 0.05},
        0.05 / math.sqrt(12.0),
        "resolution",
    ),
    "floor": ({}, NOISE_NM, NoiseSource.FLOOR),
    "resolution above the floor": ({"quantisation": STEPS_OF}, ROUNDED, NoiseSource.RESOLUTION),
}


def bench_with(seconds=0.1, **match):
    """Return a campaign of one record whose torque is matched as told."""
    made = bench(displaced(truth(), {"gear.stiffness": 1.1}), truth(), "full_46", seed=9, seconds=seconds)
    return replace(made, records=tuple(matched(r, **match) for r in made.records))


def matched(record, **match):
    return replace(record, matches=tuple(replace(m, **match) for m in record.matches))


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_level_rests_on(kind):
    """Truth: the noise added, what is declared, and a uniform error's standard deviation."""
    match, sigma, source = KINDS[kind]
    (record,) = bench_with(seconds=0.4, **match).records
    known = known_noise(record, record.matches[0])
    assert known.sigma == pytest.approx(sigma, rel=0.1)
    assert known.rests_on == source


def test_a_quiet_stretch_goes_before_the_floor():
    quiet = {"step": "quiet", "text": "", "channel": "torque", "rms": 0.003}
    (record,) = bench_with().records
    record = replace(record, data=replace(record.data, treatments=(quiet,)))
    known = known_noise(record, record.matches[0])
    assert (known.sigma, known.rests_on) == (0.003, NoiseSource.QUIET)


@pytest.mark.parametrize("quantisation", [0.0, 1e-170, 1e-4])
@pytest.mark.parametrize("sigma", [5e-324, 1e-320, 1e-160, 1e160, 1.7e308])
@pytest.mark.parametrize("gain", [1e-160, 1.0])
def test_no_declared_level_is_beyond_arithmetic(sigma, quantisation, gain):
    """Truth: a level's square and its reciprocal are finite, and the rounding is a share of it from 0 to 1."""
    (record,) = bench_with(noise_sigma=sigma, quantisation=quantisation).records
    channels = tuple(replace(c, data=gain * c.data) for c in record.data.channels)
    record = replace(record, data=replace(record.data, channels=channels))
    (channel,) = make_problem(campaign(truth(), record), 1).targets[0].channels
    assert 0.0 < channel.sigma <= LARGEST
    assert math.isfinite(channel.sigma**2)
    assert math.isfinite(1.0 / channel.sigma**2)
    assert 0.0 <= channel.rounding_share <= 1.0


def stalled(problem):
    """Return a growth that stalls after 15 ms at the problem's start."""
    return Growth(problem.start, {t.name: int(0.015 * RATE_HZ) for t in problem.targets}, False, 1)


def test_it_is_raised_step_by_step_up_to_a_share_of_what_moves():
    """Truth: the rule; the standard deviation is NumPy's, of the torque less its straight line."""
    problem = make_problem(bench_with(), 1)
    (channel,) = problem.targets[0].channels
    k = np.arange(channel.measured.size)
    most = 0.3 * np.std(channel.measured - np.polyval(np.polyfit(k, channel.measured, 1), k))
    assert NOISE.most_raised_share * moving_deviation(channel) == pytest.approx(most, rel=1e-9)
    levels = [channel.sigma]
    while (louder := raise_levels(problem, stalled(problem))) is not problem:
        problem = louder
        (channel,) = problem.targets[0].channels
        levels.append(channel.sigma)
        assert (channel.raised, channel.rests_on) == (channel.sigma, NoiseSource.RESIDUAL)
    assert levels[1:-1] == [levels[0] * NOISE.raise_factor**n for n in range(1, len(levels) - 1)]
    assert levels[-1] == pytest.approx(most, rel=1e-9)


def test_a_declared_level_and_a_followed_record_are_not_raised():
    declared, free = (make_problem(bench_with(**match), 1) for match in ({"noise_sigma": 1e-4}, {}))
    assert raise_levels(declared, stalled(declared)) is declared
    whole = Growth(free.start, {t.name: t.samples for t in free.targets}, True, 1)
    assert raise_levels(free, whole) is free


@pytest.mark.slow
def test_only_the_channel_that_stops_the_growth_is_raised(tmp_path):
    """Truth: the torque's model is right; the current has a line of 20 times its noise that no model has."""
    m = mechanism_of(paper_table())

    def disturbed(y, quantity):
        if quantity == "current_phase_a":
            y += 0.06 * np.sin(2.0 * np.pi * 150.0 * np.arange(y.size) / RATE_HZ)

    values = {name: m.value(name) for name in ("gear.stiffness", "gear.damping")}
    made = written(tmp_path, m, values, quantities=("torque", "current_phase_a"), change=disturbed, seconds=0.1)
    problem = make_problem(replace(made, mechanism=made.mechanism.with_values(values)), 1)
    for target in raise_levels(problem, stalled(problem)).targets:
        assert [c.raised > 0.0 for c in target.channels] == [False, True]


def test_what_is_not_fitted_takes_the_level_its_quantity_was_raised_to():
    """Truth: the rule; what is declared is never raised, and one record that is not raised speaks for all."""
    made = bench_with()
    known = make_problem(made, 1)
    louder = raise_levels(known, stalled(known)).targets
    (other,) = (replace(r, name="other", use="validate") for r in made.records)
    level = louder[0].leading.sigma
    noise = channel_noises(other, louder)["torque"]
    assert (noise.found.sigma, noise.found.rests_on, noise.follows) == (level, NoiseSource.RESIDUAL, level)
    assert noise.known.sigma == pytest.approx(level / NOISE.raise_factor)
    for record, targets in ((matched(other, noise_sigma=1e-4), louder), (other, (*louder, *known.targets))):
        noise = channel_noises(record, targets)["torque"]
        assert noise.found == noise.known


@pytest.mark.slow
def test_noise_whose_floor_says_nothing_is_found_and_the_fit_taken_up_again():
    """Truth: the values that made the records, within 5 sigma, and the noise added, ten times above its floor."""
    records = coloured(14, hertz=888.0, radius=0.9, samples=4001)
    made = campaign(displaced(truth(), dict.fromkeys(FREE, 1.2)), *records)
    fit = identify(made, workers=1)
    assert_true(fit)
    for record in fit.records.values():
        assert record.noise_sigma == pytest.approx(NOISE_NM, rel=0.05)
        assert record.noise_rests_on == "residual"
        assert record.noise_known < 0.2 * NOISE_NM
        assert [
            w for w in fit.warnings if w.startswith(f"record {record.name}: to follow it the noise level was raised")
        ]
    problem = fit.optimum.problem
    assert [t.leading.sigma for t in problem.targets] == pytest.approx([NOISE_NM, NOISE_NM], rel=0.05)


@pytest.mark.slow
def test_a_narrow_resonance_in_the_noise_is_followed():
    """Truth: as above; of an AR(2) process with poles of radius 0.99 at 46 Hz the floor is 400 times below its RMS."""
    records = coloured(13, hertz=46.0, radius=0.99, samples=4001, settled=10_000)
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), workers=1)
    assert_true(fit)
    assert {r.noise_rests_on for r in fit.records.values()} == {"residual"}


@pytest.mark.slow
def test_a_current_behind_a_low_pass_is_followed(tmp_path):
    """Truth: the mechanism and values that made the records; behind a low-pass a current of 3 mA noise has no floor.

    The file lacks nothing, so that terms beside, which follow at a raised level too, are not needed.
    """
    m = mechanism_of(paper_table())
    low_pass = butter(6, 1000.0, fs=RATE_HZ, output="sos")

    def filtered(y, quantity):
        if quantity.startswith("current"):
            y[:] = sosfiltfilt(low_pass, y)

    values = {name: m.value(name) for name in ("stepper.torque_constant", "stepper.coil_resistance", "gear.stiffness")}
    made = written(tmp_path, m, values, quantities=("torque", "current_phase_a"), change=filtered)
    fit = identify(replace(made, stages=()), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert (fit.grade, fit.as_written) == (Grade.A, None)
    assert_found(fit, values, sigmas=5.0)
    for record in fit.records.values():
        torque, current = record.channels.values()
        assert torque.noise_rests_on == "high-frequency floor"
        assert current.noise_rests_on == "residual"
        assert current.noise_known < 0.1 * current.noise_sigma


TWICE = 2.0
LONG, SHORT = (0, 2000), (0, 200)


def louder_problem(**changes):
    """The mechanism that made a record, whose noise is said to be twice what was added."""
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(5), seconds=0.2)
    target = target_of(record_of("full_46", torque, COMMANDS["full_46"]))
    louder = target.map_channels(lambda c: replace(c, sigma=TWICE * NOISE_NM, **changes))
    return Problem(SearchSpace(truth()), (louder,), substeps=4)


def level_of(found):
    return found.targets[0].leading.sigma


def test_a_level_above_what_is_left_falls_to_it():
    """Truth: the noise that was added; 2000 samples tell it to 2 %, three standard errors are 5 %."""
    made = louder_problem()
    assert level_of(lower_levels(made, made.start, {"full_46": LONG})) == pytest.approx(NOISE_NM, rel=0.05)


@pytest.mark.parametrize("rests_on", [NoiseSource.DECLARED, NoiseSource.QUIET, NoiseSource.RESIDUAL])
def test_a_level_that_rests_on_more_than_high_frequencies_stays(rests_on):
    made = louder_problem(rests_on=rests_on)
    assert lower_levels(made, made.start, {"full_46": LONG}) is made


def test_a_short_stretch_says_nothing():
    made = louder_problem()
    assert lower_levels(made, made.start, {"full_46": SHORT}) is made


def test_a_level_that_is_right_stays():
    """Truth: the level is that of the noise added."""
    made = louder_problem().with_sigmas({"full_46": NOISE_NM})
    assert lower_levels(made, made.start, {"full_46": LONG}) is made


def test_no_level_falls_below_the_resolution():
    made = louder_problem(rounding=1.5 * NOISE_NM)
    assert level_of(lower_levels(made, made.start, {"full_46": LONG})) == 1.5 * NOISE_NM


def test_levels_go_over_to_a_problem_of_the_same_records():
    made = louder_problem()
    quieter = lower_levels(made, made.start, {"full_46": LONG})
    assert level_of(copy_levels(made, quieter)) == level_of(quieter)
