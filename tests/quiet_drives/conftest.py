"""A small quiet drive of the paper's mechanism: eight microsteps, one design rate, a short range."""

import pytest

import mechid
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.identification.result.fit_file import read_fit
from paper_estimate import write_estimate_of_paper

SMALL = {
    "rates": [30.0],
    "orders": [1.0, 2.0],
    "range": {"from": 28.0, "to": 33.0},
    "microsteps": 8,
    "bits": 10,
    "steppings": ["micro"],
}


@pytest.fixture(scope="session")
def fit(tmp_path_factory):
    """Return a fit of the paper's mechanism, at the values of the paper."""
    return read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("quiet")))


@pytest.fixture(scope="session")
def mechanism(fit):
    """Return its mechanism in flight."""
    return flying_estimate(fit, Flight()).mechanism


@pytest.fixture(scope="session")
def found(fit):
    """Return its quiet drive, tried on itself as another unit; not to be changed."""
    return mechid.quiet(fit, SMALL, fleet=[fit])
