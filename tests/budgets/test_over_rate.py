"""Bands over the rate: each value lies within its interval. Truth: closed forms and draws."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import respond
from mechid.budgets.other_errors import OtherError
from mechid.budgets.over_rate import level_curve, rms_bands, torque_bands, total_bands
from mechid.budgets.requirement import Requirement
from mechid.budgets.residual_source import ResidualHere
from mechid.identification.result.fit_file import read_fit
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper
from states_by_hand import state_by_hand

RATE = 20.0
STRUCTURE = Structure(
    name="s",
    line_of_sight=("x",),
    model=Modes(np.array([300.0]), np.array([0.01]), np.array([1.0]), np.array([[1.0]])),
)
"""Stiff: below its mode all frequencies reach the line of sight alike."""


MOVED = 0.05
"""Of each line by the parameter's sigma."""


LINES = {0.5: 0.3, 1.0: 1.0, 2.0: 0.4}
"""Of the model's torque by order, N m."""


@pytest.fixture(scope="module")
def estimate(tmp_path_factory):
    """Return an estimate of one parameter that moves each line by 5 %."""
    flying = flying_estimate(read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("estimate"))), Flight())
    return replace(
        flying, names=("gear.damping",), covariance=np.eye(1), discrepancy=Discrepancy(of_profiles_alone=True)
    )


def lacking(lines, *, hidden=0.0, density=0.0, rates=4):
    """Return what a model lacks: lines by their order, N m, and a density up to 100 Hz."""
    orders = np.array(TRACKED)
    amplitude = np.array([lines.get(q, 0.0) for q in TRACKED])
    flat = np.where(CENTRES_HZ < 100.0, density, 0.0)
    return ResidualHere(
        rate=RATE,
        orders=orders,
        amplitude=amplitude,
        limit=np.where(amplitude > 0.0, amplitude, hidden),
        density=flat,
        rates=rates,
        known=np.ones(orders.size, dtype=bool),
        outside=False,
    )


def response_with(here):
    values = np.array(list(LINES.values()))
    orders = [round(2 * order) for order in LINES]
    state = state_by_hand(RATE, orders, values, gradient=MOVED * values[:, None].astype(complex))
    return respond(state, STRUCTURE, here, 200.0)


LACKING = {
    "nothing": None,
    "little at its lines": lacking({1.0: 0.1}),
    "as much at its lines": lacking({1.0: 1.0, 2.0: 1.0}),
    "four times as much": lacking({0.5: 2.0, 1.0: 4.0, 2.0: 2.0}),
    "at another order": lacking({0.75: 3.0}),
    "a density": lacking({}, density=0.05),
    "all of these, and hidden lines": lacking({1.0: 1.0, 0.75: 2.0}, density=0.02, hidden=0.5),
    "known from one rate": lacking({1.0: 1.0, 0.75: 1.0}, rates=1),
}


def requirement():
    return Requirement(
        name="r",
        index=Index("RPE", 0.1),
        axis="x",
        limit_rad=1.0,
        interpretation="temporal",
        confidence=0.95,
        evaluation_period_s=60.0,
    )


@pytest.mark.parametrize("here", LACKING.values(), ids=LACKING)
def test_the_value_lies_within_its_interval(estimate, here):
    """Truth: of what is believed, which no error moves to one side."""
    response = response_with(here)
    (lines,), ((low, high),) = response.rms(), rms_bands([response], estimate, 0)[0]
    assert low < lines < high
    (total,), ((low, high),) = response.total_rms(), total_bands([response], estimate, 0)[0]
    assert low < total < high
    for errors in ((), (OtherError(name="n", kind="random", axes=np.array([True]), size_rad=1e-6, bandwidth_hz=50.0),)):
        curve = level_curve(requirement(), [[response]], estimate, errors, 0)
        assert curve.band[0, 0] < curve.level[0] < curve.band[0, 1]
    (band,) = torque_bands([response], estimate, 0)
    assert np.all((band[:, 0] < np.abs(response.state.lines)) & (np.abs(response.state.lines) < band[:, 1]))


def test_the_interval_of_the_lines_is_that_of_the_lines(estimate):
    """Truth: a parameter that moves all lines alike by 5 %; what the model lacks has no part in it."""
    response = response_with(LACKING["four times as much"])
    expected = response.rms()[0] * (1.0 + MOVED * np.array([-1.96, 1.96]))
    np.testing.assert_allclose(rms_bands([response], estimate, 0)[0, 0], expected, rtol=0.03)


def test_the_total_against_the_closed_form(estimate):
    """Truth: mean squares add up; a stiff structure turns each N m into 1/w0^2 rad (w below its mode)."""
    response = response_with(lacking({1.0: 0.6, 0.75: 0.8}))
    gain = {q: abs(STRUCTURE.to_line_of_sight(np.array([q * RATE]))[0, 0]) for q in (*LINES, 0.75)}
    lines = sum(0.5 * (gain[q] * size) ** 2 for q, size in LINES.items())
    beside = 0.5 * (gain[1.0] * 0.6) ** 2 + 0.5 * (gain[0.75] * 0.8) ** 2
    assert response.total_rms()[0] == pytest.approx(np.sqrt(lines + beside), rel=1e-9)


def test_the_interval_of_the_total_is_that_of_what_may_be(estimate):
    """Truth: 20 000 draws of lines 5 % off and of what is lacking, whose power is F(2, 2 n) distributed."""
    rng, n, count = np.random.default_rng(7), 4, 20_000
    response = response_with(lacking({1.0: 1.0}, rates=n))
    at = np.array([q * RATE for q in LINES])
    gain = np.abs(STRUCTURE.to_line_of_sight(at)[:, 0])
    lines = np.array(list(LINES.values())) * (1.0 + MOVED * rng.normal(size=(count, 1)))
    power = rng.f(2, 2 * n, size=count)
    lines = lines.astype(complex)
    lines[:, 1] += np.sqrt(power) * np.exp(2j * np.pi * rng.random(count))
    true = np.sqrt(0.5 * np.sum(np.abs(gain * lines) ** 2, axis=1))
    ends = np.array([total_bands([response], estimate, seed)[0, 0] for seed in range(20)])
    assert np.mean(true < ends[:, :1]) == pytest.approx(0.025, abs=0.01)  # each by the quantiles of 200 draws
    assert np.mean(true > ends[:, 1:]) == pytest.approx(0.025, abs=0.01)
