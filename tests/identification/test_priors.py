"""Priors: what they add to an estimate, where they are left out, and what the report says of them."""

from dataclasses import replace

import pytest

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.identify import identify
from mechid.identification.search.settings import SEARCH
from mechid.reports.numbers import report_data
from synthetic import bench, displaced, truth

DAMPING = "gear.damping"
SHORT_S = 0.12
FLAT = SEARCH.negligible_fall**0.5
"""Standard errors within which the solver does not seek the optimum."""


def fitted(priors, sigma, start=1.002):
    """Return the fit of the damping alone, which the torque is all but linear in, with a prior at its start."""
    mechanism = displaced(truth(), {DAMPING: start})
    mechanism = mechanism.with_parameters({DAMPING: replace(mechanism.parameters[DAMPING], sigma=sigma)})
    made = bench(mechanism, truth(), "full_46", seed=61, seconds=SHORT_S)
    return identify(replace(made, options=IdentifyOptions(priors=priors)), workers=1)


@pytest.fixture(scope="module")
def alone():
    """Return the estimate from the record alone."""
    return fitted("none", None).parameters[DAMPING]


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_prior_combines_with_the_record_by_precision(alone, share):
    """Truth: the mean weighted by 1/sigma^2 of the record's estimate and the prior, and 1/sqrt of their sum."""
    sigma = share * alone.std_error_white
    p = fitted("fit", sigma).parameters[DAMPING]
    weights = 1.0 / alone.std_error_white**2, 1.0 / sigma**2
    wanted = (weights[0] * alone.value + weights[1] * p.start) / sum(weights)
    assert p.value == pytest.approx(wanted, abs=0.02 * sigma)
    assert p.std_error_white == pytest.approx(sum(weights) ** -0.5, rel=0.01)
    assert p.prior.std_error_without == pytest.approx(alone.std_error_white, rel=0.01)
    assert p.prior.dominates is (share < 1.0)
    assert ("mainly its prior's" in p.reason) is (share < 1.0)


@pytest.mark.parametrize("priors", ["search", "none"])
def test_a_prior_left_out_leaves_no_trace_in_the_values(alone, priors):
    """Truth: the fit of the record alone; the prior is shown all the same, as not counted."""
    assert abs(alone.start - alone.value) > 2.0 * alone.std_error  # the prior pulls where it counts
    p = fitted(priors, 2.0 * alone.std_error_white).parameters[DAMPING]
    assert p.value == pytest.approx(alone.value, abs=FLAT * alone.std_error)
    assert p.std_error == pytest.approx(alone.std_error, rel=1e-3)
    assert (p.prior.counted, p.prior.std_error_without) == (False, None)


@pytest.mark.parametrize("priors", ["search", "none"])
def test_what_the_record_tells_less_well_than_the_file_is_held_there(alone, priors):
    """Truth: the mechanism file, whose sigma is below the error of the record alone."""
    p = fitted(priors, 0.3 * alone.std_error_white).parameters[DAMPING]
    assert (p.status, p.value) == ("frozen", p.start)
    assert "exceeds its prior's" in p.reason


def test_the_report_shows_the_prior_and_what_the_records_alone_say(alone):
    """Truth: the mechanism file, and the fit of the record alone."""
    fit = fitted("fit", alone.std_error_white)
    row = next(r for r in report_data(fit)["parameters"] if r["name"] == DAMPING)
    assert row["prior"]["value"] == fit.parameters[DAMPING].start
    assert row["prior"]["sigma"] == alone.std_error_white
    assert float(row["text"]["without_prior"]) == pytest.approx(alone.std_error_white, rel=0.01)
    assert fit.to_dict()["parameters"][DAMPING]["prior"] == row["prior"]
