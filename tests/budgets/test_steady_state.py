"""Lines of the steady torque, their derivatives and the line of sight, against other ways to the same."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.ensemble import make_ensemble
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orders import phasors
from mechid.budgets.requirement import Requirement
from mechid.budgets.standing import assess_standing, nominal_level
from mechid.budgets.steady_state import steady_state
from mechid.budgets.summation import coverage_factor
from mechid.command import Command, RateProfile
from mechid.identification.result.fit_file import read_fit
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper

MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(37.3))
MODE = OperatingMode(name="scan", command=MICRO, rates=np.array([37.3]), settle_s=1.0, highest_hz=300.0)
SUBSTEPS = 4
PAYLOAD = Modes(np.array([35.0]), np.array([0.01]), np.array([0.2]), np.array([[0.05]]))
REQUIREMENT = Requirement(
    name="r",
    index=Index("RPE", 0.2),
    axis="x",
    limit_rad=1e-6,
    interpretation="temporal",
    confidence=0.95,
    evaluation_period_s=10.0,
)


def test_lines_are_those_of_a_long_run(state, long_run):
    """Truth: least squares over the last two seconds of a long simulation, on no whole number of periods."""
    expected = np.abs(phasors(long_run[60_000:], 20_000.0, state.frequency_hz))
    assert state.unsteady < 1e-3
    assert state.rms == pytest.approx(long_run[60_000:].std(), rel=2e-3)
    np.testing.assert_allclose(np.abs(state.lines), expected, atol=2e-3 * expected.max())


def test_gradients_are_those_of_differences(flying, state):
    """Truth: central differences of a thousandth of each value, over the whole steady state."""
    for k, name in enumerate(flying.names):
        value = flying.mechanism.value(name)
        step = 1e-3 * value
        ends = [
            steady_state(flying.mechanism.with_values({name: value + s}), MODE, 37.3, (), SUBSTEPS).lines
            for s in (step, -step)
        ]
        expected = (ends[0] - ends[1]) / (2.0 * step)
        size = np.abs(expected).max()
        np.testing.assert_allclose(state.gradient[:, k], expected, atol=0.02 * size, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize(("draws", "within"), [(300, 0.15), (10_000, 0.021)])
def test_the_band_is_the_scatter_of_resimulated_draws(flying, state, draws, within):
    """Truth: mechanisms drawn from the covariance, each simulated anew; of n draws sigma is known to 1/sqrt(2 n)."""
    structure = Structure(name="s", line_of_sight=("x",), model=PAYLOAD)
    none = make_ensemble((), np.zeros(0), (), seed=0)
    band = assess_standing(REQUIREMENT, "scan", [(1.0, respond(state, structure))], flying, none).level
    rng = np.random.default_rng(8)
    nominal = np.array([flying.mechanism.value(name) for name in flying.names])
    levels = []
    for draw in rng.multivariate_normal(nominal, flying.covariance, draws):
        moved = flying.mechanism.with_values(dict(zip(flying.names, draw, strict=True)))
        response = respond(steady_state(moved, MODE, 37.3, (), 2), structure)
        levels.append(nominal_level(REQUIREMENT, [(1.0, response)]))
    assert band.sigma == pytest.approx(np.std(levels), rel=within)
    assert band.value == pytest.approx(np.mean(levels), abs=3.0 * band.sigma / np.sqrt(draws) + 0.1 * band.sigma)
    assert sum(band.shares.values()) == pytest.approx(1.0)


def _certain(flying):
    """Return the estimate without uncertainty, so that only the level is worked out."""
    return replace(flying, names=(), covariance=np.zeros((0, 0)), discrepancy=Discrepancy())


@pytest.mark.parametrize(("noise", "expected"), [(0.0, 0.05), (0.8e-3, 0.03), (0.999e-3, 0.0)])
def test_what_the_model_misses_beyond_the_noise(tmp_path, noise, expected):
    """Truth: 5 % missed with a residual of 1e-3, of which the noise is nothing, 0.8 of it, or all but chance."""
    path = write_estimate_of_paper(tmp_path, fit_percent=95.0)
    content = json.loads(path.read_text(encoding="utf-8"))
    content["records"]["sweep"]["noise_sigma"] = noise
    path.write_text(json.dumps(content), encoding="utf-8")
    assert flying_estimate(read_fit(path), Flight()).discrepancy.overall == pytest.approx(expected, abs=1e-12)


def test_a_noise_level_that_rests_on_the_residual_excuses_nothing(tmp_path):
    """Truth: as above, with nothing of the noise known beforehand."""
    path = write_estimate_of_paper(tmp_path, fit_percent=95.0)
    content = json.loads(path.read_text(encoding="utf-8"))
    torque = {"unit": "N m", "use": "validate", "fit_percent": 95.0, "residual_rms": 1e-3, "noise_sigma": 1e-3}
    torque |= {"offset": None, "drift": None, "rejected_runs": [], "noise_rests_on": "residual", "noise_known": 0.0}
    content["records"]["sweep"] |= {"noise_sigma": 1e-3, "channels": {"torque": torque}}
    path.write_text(json.dumps(content), encoding="utf-8")
    assert flying_estimate(read_fit(path), Flight()).discrepancy.overall == pytest.approx(0.05, abs=1e-12)


def test_a_spread_makes_an_ensemble(flying):
    """Truth: units n_p standard deviations off, simulated anew. Temporal is the worse of them."""
    structure = Structure(name="s", line_of_sight=("x",), model=PAYLOAD)
    name, sigma = "stepper.peak_voltage", 0.02
    state = steady_state(flying.mechanism, MODE, 37.3, (name,), SUBSTEPS)
    units = make_ensemble((name,), np.array([sigma]), (), seed=1)
    worst = assess_standing(REQUIREMENT, "scan", [(1.0, respond(state, structure))], _certain(flying), units)
    levels = []
    for draw in coverage_factor(REQUIREMENT.confidence) * np.array([-1.0, 1.0]):
        moved = flying.mechanism.with_values({name: flying.mechanism.value(name) + draw * sigma})
        unit = respond(steady_state(moved, MODE, 37.3, (), SUBSTEPS), structure)
        levels.append(nominal_level(REQUIREMENT, [(1.0, unit)]))
    assert worst.level.value == pytest.approx(max(levels), rel=2e-3)
    assert worst.level.value > worst.nominal_rad == nominal_level(REQUIREMENT, [(1.0, respond(state, structure))])
    assert worst.spread_shares[name] > 0.9
