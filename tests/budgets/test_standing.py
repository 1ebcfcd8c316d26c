"""Requirements with other sources, duty and an ensemble, against closed forms and draws; ECSS's table by draws."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, stats

from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.ensemble import make_ensemble
from mechid.budgets.example import write_example
from mechid.budgets.findings import findings
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import Response, respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.other_errors import OtherError
from mechid.budgets.over_rate import level_curve, rms_bands
from mechid.budgets.requirement import Requirement
from mechid.budgets.standing import DISCREPANCY, SAMPLING, assess_standing, nominal_level
from mechid.budgets.steady_state import steady_state
from mechid.budgets.summation import Contribution, coverage_factor, moments, total
from mechid.command import Command, RateProfile
from mechid.identification.result.fit_file import read_fit
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper
from states_by_hand import state_by_hand

APE = Index("APE")
ONE = np.array([True])
NOBODY = make_ensemble((), np.zeros(0), (), seed=0)


def requirement(index=APE, confidence=0.95, interpretation="temporal"):
    return Requirement(
        name="r",
        index=index,
        axis="x",
        limit_rad=1.0,
        interpretation=interpretation,
        confidence=confidence,
        evaluation_period_s=100.0,
    )


def line(amplitude, rate=20.0, slopes=()):
    """Return a response of one line at the step rate; its derivatives are `slopes`."""
    gradient = np.array([slopes], dtype=complex).reshape(1, len(slopes))
    state = state_by_hand(rate, [2], [amplitude], gradient=gradient)
    unit = np.ones((1, 1), dtype=complex)
    return Response(("x",), state, unit, state.lines[:, None], 0.0, None)


@pytest.fixture(scope="module")
def certain(tmp_path_factory):
    """Return an estimate without uncertainty."""
    flying = flying_estimate(read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("estimate"))), Flight())
    return replace(flying, names=(), covariance=np.zeros((0, 0)), discrepancy=Discrepancy())


def test_duty_is_the_share_of_the_time(certain):
    """Truth: of a line run for a share d of the time, rest else, the quantile c is that of (c - (1 - d))/d."""
    duty, c = 0.2, 0.9
    got = assess_standing(requirement(confidence=c), "m", [(duty, line(2.0))], certain, NOBODY)
    assert got.level.value == pytest.approx(2.0 * np.sin(0.5 * np.pi * (c - (1.0 - duty)) / duty), rel=2e-3)
    rests = assess_standing(requirement(confidence=0.7), "m", [(duty, line(2.0))], certain, NOBODY)
    assert rests.level.value == pytest.approx(0.0, abs=0.01)


def test_two_modes_by_duty(certain):
    """Truth: the mixture of two arcsine distributions."""
    got = assess_standing(requirement(), "m", [(0.5, line(1.0)), (0.5, line(3.0))], certain, NOBODY).level.value
    reached = [2.0 / np.pi * np.arcsin(min(got / a, 1.0)) for a in (1.0, 3.0)]
    assert np.mean(reached) == pytest.approx(0.95, abs=1e-3)


def test_other_sources_add_to_the_lines(certain):
    """Truth: a million draws of line, wheel, bias and noise."""
    errors = (
        OtherError(name="b", kind="bias", axes=ONE, size_rad=0.5),
        OtherError(name="n", kind="random", axes=ONE, size_rad=0.4, bandwidth_hz=3.0),
        OtherError(name="w", kind="periodic", axes=ONE, size_rad=0.7, frequency_hz=33.0),
    )
    rng = np.random.default_rng(11)
    turns = rng.uniform(0.0, 2.0 * np.pi, (2, 1_000_000))
    draws = 2.0 * np.cos(turns[0]) + 0.7 * np.cos(turns[1]) + 0.5 + rng.normal(0.0, 0.4, 1_000_000)
    for c in (0.68, 0.9545, 0.9973):
        got = nominal_level(requirement(confidence=c), [(1.0, line(2.0))], errors)
        assert got == pytest.approx(np.quantile(np.abs(draws), c), rel=5e-3)


def test_an_ensemble_of_biases(certain):
    """Truth: draws over time of the member n_p deviations off; all of the spread is the bias's."""
    bias = OtherError(name="b", kind="bias", axes=ONE, size_rad=1.0, spread_rad=0.3)
    units = make_ensemble((), np.zeros(0), (bias,), seed=2)
    c = 0.9
    got = assess_standing(requirement(confidence=c), "m", [(1.0, line(0.5))], certain, units)
    worst = 1.0 + 0.3 * coverage_factor(c)
    rng = np.random.default_rng(12)
    draws = np.abs(worst + 0.5 * np.cos(rng.uniform(0.0, 2.0 * np.pi, 1_000_000)))
    assert got.level.value == pytest.approx(np.quantile(draws, c), rel=2e-3)
    assert got.spread_shares["error b"] > 0.99


TRUTHS = {
    "temporal": lambda c: (2.0 + 0.2 * coverage_factor(c)) * np.sin(0.5 * np.pi * c),
    "ensemble": lambda c: 2.0 + 0.2 * stats.norm.ppf(c),
    "mixed": lambda c: optimize.brentq(lambda x: _below(x) - c, 1.0, 4.0),
}
"""Levels of a line whose amplitude is Gaussian over the ensemble, 2 +- 0.2: of the member n_p deviations off over
time, of the members' peaks, of all times of all members."""


def _below(x):
    z, step = np.linspace(-8.0, 8.0, 100_001, retstep=True)
    return step * np.sum(stats.norm.pdf(z) * 2.0 / np.pi * np.arcsin(np.minimum(x / (2.0 + 0.2 * z), 1.0)))


@pytest.mark.parametrize("confidence", [pytest.param(0.9545, marks=pytest.mark.slow), 0.9973])
@pytest.mark.parametrize("interpretation", TRUTHS)
def test_a_level_moves_with_the_seed_by_no_more_than_its_sampling_error(certain, interpretation, confidence):
    """Truth: the closed forms. The stated standard error is that of the seeds, and 2 % of the spread in the mean."""
    asked, truth = requirement(APE, confidence, interpretation), TRUTHS[interpretation](confidence)
    found = [
        assess_standing(
            asked, "m", [(1.0, line(2.0, slopes=(1.0,)))], certain, make_ensemble(("p",), np.array([0.2]), (), seed)
        )
        for seed in range(8)
    ]
    off = np.array([s.level.value for s in found]) - truth
    stated = np.array([s.sampling_rad for s in found])
    assert np.all(np.abs(off) < 2.5 * stated)
    assert 0.3 < np.sqrt(np.mean((off / stated) ** 2)) < 1.3
    assert np.sqrt(np.mean(off**2)) < 0.003
    assert stated.mean() < 0.02 * 0.2
    assert found[0].level.sigma == pytest.approx(stated[0])  # nothing else is uncertain here
    assert found[0].level.shares[SAMPLING] == pytest.approx(1.0)
    assert found[0].margin95[0] == pytest.approx(found[0].margin - 1.96 * stated[0], abs=1e-5)


def test_a_nominal_unit_alone_has_no_sampling_error(certain):
    got = assess_standing(requirement(), "m", [(1.0, line(2.0))], certain, NOBODY)
    assert (got.sampling_rad, got.level.value, got.spread_shares) == (0.0, got.nominal_rad, {})


@pytest.mark.parametrize("kind", ["bias", "random", "periodic"])
@pytest.mark.parametrize("interpretation", ["temporal", "ensemble", "mixed"])
def test_the_table_of_moments_by_its_definitions(kind, interpretation):
    """Truth: draws of members and times. Temporal: the member at mean and n_p deviations, over time. Ensemble: each
    member at its worst time, which of Gaussian noise is n_p deviations. Mixed: every time of every member."""
    n_p, size, spread = 2.0, 3.0, 0.4
    rng = np.random.default_rng(13)
    members = size + spread * rng.normal(size=2_000_000)
    if interpretation == "temporal":
        members = np.full(members.size, size + n_p * spread)
    over_time = {
        "bias": members,
        "random": members * rng.normal(size=members.size),
        "periodic": members * np.cos(rng.uniform(0.0, 2.0 * np.pi, members.size)),
    }[kind]
    at_worst = members * (n_p if kind == "random" else 1.0)
    values = at_worst if interpretation == "ensemble" else over_time
    got = moments(Contribution(name="e", kind=kind, size=size, spread=spread), interpretation, n_p)
    np.testing.assert_allclose(got, (values.mean(), values.std()), atol=0.01)


def test_the_ecss_sum_of_a_line_with_other_sources(certain):
    """Truth: the standard's rules by hand: |mean| + n_p of the root of the squares' sum."""
    errors = (
        OtherError(name="b", kind="bias", axes=ONE, size_rad=0.5),
        OtherError(name="n", kind="random", axes=ONE, size_rad=0.4, bandwidth_hz=3.0),
    )
    units = make_ensemble((), np.zeros(0), errors, seed=0)
    got = assess_standing(requirement(confidence=0.9973), "m", [(1.0, line(2.0))], certain, units).ecss_rad
    assert got == pytest.approx(0.5 + coverage_factor(0.9973) * np.sqrt(2.0 + 0.16), rel=1e-3)
    alone = [Contribution(name="waveform", kind="periodic", size=2.0, form=0.9)]
    assert total(alone, "mixed", 0.95) == pytest.approx(coverage_factor(0.95) * 1.8)


def test_what_the_model_misses_of_each_line(tmp_path, certain):
    """Truth: the errors of the orders in the record's validation; a line's level is off by as much."""
    path = write_estimate_of_paper(tmp_path, fit_percent=90.0)
    order = dict.fromkeys(("measured", "modelled", "peak_rate", "peak_measured", "peak_modelled"), 1.0) | {"windows": 1}
    order |= {"order": 1.0, "amplitude_error_percent": 3.0, "phase_error_deg": np.degrees(0.04)}
    other = {**order, "order": 2.0, "amplitude_error_percent": None, "phase_error_deg": None}
    channel = {"samples": 9, "samples_sha256": "", "effective_samples": 9, "residual_rms": 1.0, "fit_percent": 90.0}
    channels = {
        "rotor_rate": {**channel, "orders": [{**order, "amplitude_error_percent": 50.0}]},
        "torque": {**channel, "orders": [order, other]},
    }
    content = json.loads(path.read_text(encoding="utf-8"))
    content["records"]["sweep"]["validation"] = {"command": {}, "judged_from_s": None, "channels": channels}
    path.write_text(json.dumps(content), encoding="utf-8")
    missed = flying_estimate(read_fit(path), Flight()).discrepancy
    assert missed.orders == pytest.approx({1.0: 0.05})
    np.testing.assert_allclose(missed.of_lines(np.array([0.5, 1.0])), [0.1, 0.05])
    off = assess_standing(requirement(), "m", [(1.0, line(2.0))], replace(certain, discrepancy=missed), NOBODY).level
    assert off.sigma / off.value == pytest.approx(0.05, rel=0.15)
    assert off.shares[DISCREPANCY] == pytest.approx(1.0)


SCAN = OperatingMode(
    name="scan",
    command=Command(stepping="micro", microsteps=16, rate=RateProfile.constant(37.3)),
    rates=np.array([37.3]),
    settle_s=1.0,
    highest_hz=300.0,
)
PAYLOAD = Modes(np.array([35.0]), np.array([0.01]), np.array([0.2]), np.array([[0.05]]))
STRUCTURE = Structure(name="s", line_of_sight=("x",), model=PAYLOAD)


def test_an_error_of_the_bench_voltage_is_one_of_the_flight_voltage(flying):
    """Truth: U -> c U, k_m -> c k_m, R, L -> c^2 leaves the torque; so c in the three alone is 1/c in the voltage."""
    c, v = 1.03, flying.mechanism.value
    three = {"stepper.torque_constant": c, "stepper.coil_resistance": c**2, "stepper.coil_inductance": c**2}
    scaled = flying.mechanism.with_values({name: factor * v(name) for name, factor in three.items()})
    other = flying.mechanism.with_values({"stepper.peak_voltage": v("stepper.peak_voltage") / c})
    lines = [steady_state(m, SCAN, 37.3, (), 4).lines for m in (scaled, other)]
    np.testing.assert_allclose(lines[0], lines[1], atol=1e-6 * np.abs(lines[0]).max())


@pytest.mark.slow
def test_bands_over_the_rate_are_those_of_units_simulated_anew(flying):
    """Truth: 200 mechanisms drawn from the covariance, simulated anew; a quantile of them is good to a tenth."""
    state = steady_state(flying.mechanism, SCAN, 37.3, flying.names, 4)
    response = respond(state, STRUCTURE)
    low, high = rms_bands([response], flying, seed=1)[0, 0]
    rng = np.random.default_rng(9)
    nominal = np.array([flying.mechanism.value(name) for name in flying.names])
    rms = []
    for draw in rng.multivariate_normal(nominal, flying.covariance, 200):
        moved = flying.mechanism.with_values(dict(zip(flying.names, draw, strict=True)))
        rms.append(respond(steady_state(moved, SCAN, 37.3, (), 2), STRUCTURE).rms()[0])
    expected = np.quantile(rms, [0.025, 0.975])
    np.testing.assert_allclose([low, high], expected, atol=0.15 * np.ptp(expected))
    curve = level_curve(requirement(), [[response]], flying, (), seed=1)
    whole = assess_standing(requirement(), "scan", [(1.0, response)], flying, NOBODY).level
    assert curve.level[0] == pytest.approx(whole.value, rel=1e-9)
    assert np.ptp(curve.band[0]) == pytest.approx(np.ptp(whole.ci95), rel=0.2)


def test_a_free_body_is_told_where_slow_errors_are_asked(tmp_path, flying):
    write_estimate_of_paper(tmp_path)
    write_example(tmp_path)
    path = tmp_path / "budget.toml"
    assert not any("rigid body is free" in w for w in findings(read_budget_file(path), flying, ()))
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("attitude_control =", "# attitude_control ="), encoding="utf-8")
    (told,) = (w for w in findings(read_budget_file(path), flying, ()) if "rigid body is free" in w)
    assert "pointing asks for absolute or drift errors; give [structure] attitude_control" in told


def test_a_confidence_of_noise_is_gaussian(certain):
    """Truth: the normal quantile, where the mechanism is as good as silent."""
    noise = OtherError(name="n", kind="random", axes=ONE, size_rad=1.0, bandwidth_hz=3.0)
    got = nominal_level(requirement(confidence=0.9), [(1.0, line(1e-6))], (noise,))
    assert got == pytest.approx(stats.norm.ppf(0.95), rel=1e-3)
