"""`Fit.linear`: the linear models of a fit as identify returns it."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import Stage
from mechid.errors import UsageError
from mechid.identification.identify import identify
from synthetic import bench, truth


@pytest.fixture(scope="module")
def fitted():
    """Return a short synthetic campaign and its fit, the gear's stiffness alone free."""
    campaign = bench(truth().with_free(("gear.stiffness",)), truth(), "full_46", seed=6, seconds=0.1)
    campaign = replace(campaign, stages=(Stage(records=("full_46",), window_s=None, free=("gear.stiffness",)),))
    return campaign, identify(campaign)


def test_the_linear_models_of_a_fit(fitted):
    """Truth: a stuck load swings at sqrt(K/J) of the fit's own stiffness, and half its relative error in frequency."""
    campaign, fit = fitted
    linear = fit.linear(campaign, rates=(), samples=200, seed=1, anyway=True)
    estimate = fit.parameters["gear.stiffness"]
    assert linear.uncertain.names == ("gear.stiffness",)
    assert linear.uncertain.std_errors[0] == pytest.approx(estimate.std_error, rel=1e-12)
    model = linear["stuck"]

    def swing(A):
        return np.abs(np.linalg.eigvals(A)).max()

    coils = 9.9 / 0.045
    load = np.sqrt(estimate.value / 0.010534)
    assert swing(model.matrices.A) == pytest.approx(max(load, coils), rel=1e-9)
    drawn = np.array([swing(A) for A in model.samples.A])
    expected = 0.5 * estimate.std_error / estimate.value
    assert np.std(drawn) / load == pytest.approx(expected, rel=0.2)
    assert linear.held.command.start_angle_deg == 45.0


def test_without_a_campaign_it_holds_0_degrees(fitted):
    """Truth: nothing is known of the start; and what cannot be is refused."""
    _, fit = fitted
    assert fit.linear(samples=0, anyway=True).held.command.start_angle_deg == 0.0
    assert fit.linear(samples=0, start_angle_deg=30.0, anyway=True).held.command.start_angle_deg == 30.0
    with pytest.raises(UsageError, match="rates: found -1"):
        fit.linear(rates=[-1.0], anyway=True)
