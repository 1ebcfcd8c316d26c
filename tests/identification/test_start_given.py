"""A fit from a start that is given. Truth: the mechanism that made the records."""

import pytest

import synthetic
from mechid.errors import FitError
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.start_given import identify_from
from synthetic import displaced

START = {"gear.stiffness": 1.15, "gear.damping": 0.8, "friction.viscous": 1.1}


@pytest.fixture(scope="module")
def campaign():
    """Return two records whose file's start is far off; the start that is given is not."""
    far = {"gear.stiffness": 2.4, "gear.damping": 1.2, "friction.viscous": 0.2}
    return synthetic.bench(
        displaced(synthetic.truth(), far), synthetic.truth(), "full_46", "micro_92", seed=3, seconds=0.3
    )


def test_it_comes_to_the_truth_and_tells_how(campaign):
    reports = []
    values = {name: synthetic.truth().value(name) * factor for name, factor in START.items()}
    fit = identify_from(campaign, values, workers=1, listener=reports.append)
    assert fit.outcome is FitOutcome.CONVERGED
    for name in START:
        p = fit.parameters[name]
        assert abs(p.value - synthetic.truth().value(name)) < 4.0 * p.std_error
        assert reports[0].values[name] == pytest.approx(values[name], rel=1e-9)
        assert reports[-1].values[name] == pytest.approx(p.value, rel=1e-9)
    samples = sum(r.data.samples for r in campaign.records)
    assert reports[0].cost > 10.0 * samples
    assert [r.number for r in reports] == sorted(r.number for r in reports)
    assert all(0 < r.number <= r.total for r in reports)


def test_nothing_free_is_said(campaign):
    held = synthetic.bench(synthetic.truth().with_free(()), synthetic.truth(), "full_46", seed=3, seconds=0.05)
    with pytest.raises(FitError, match="nothing to estimate"):
        identify_from(held, {})
