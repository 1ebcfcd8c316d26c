"""Truth: the Fisher matrix by differences of the simulation, offset and drift projected out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from mechid.analysis.information import record_information
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.record_result import RecordFit
from mechid.simulation.resonances import resonances
from synthetic import COMMANDS, campaign, displaced, record, torque_of, truth

FREE = ("gear.stiffness", "gear.damping")
NAMES = ("full_46", "micro_46")
SIGMA = {"full_46": 0.002, "micro_46": 0.004}
SAMPLES = 2001


@pytest.fixture(scope="module")
def made():
    mechanism = displaced(truth(), dict.fromkeys(FREE, 1.0))
    records = [record(n, torque_of(truth(), COMMANDS[n], SAMPLES), COMMANDS[n]) for n in NAMES]
    fits = {
        n: RecordFit(
            name=n,
            use="estimate",
            samples=SAMPLES,
            fit_percent=99.0,
            residual_rms=SIGMA[n],
            noise_sigma=SIGMA[n],
            offset=0.0,
            drift=0.0,
            horizon_s=0.2,
        )
        for n in NAMES
    }
    parameters = {name: estimate(name, mechanism) for name in FREE}
    fit = fit_by_hand(mechanism, parameters=parameters, records=fits, provenance={"substeps": 4})
    return campaign(mechanism, *records), fit


def estimate(name, mechanism):
    q = mechanism.parameters[name]
    return ParameterEstimate(
        name=name,
        symbol="",
        unit="",
        value=q.value,
        std_error=1.0,
        std_error_white=1.0,
        start=q.value,
        min=q.min,
        max=q.max,
        status="free",
    )


def fisher_by_differences(name, mechanism):
    """Return J^T J / sigma^2 by central differences, offset and drift removed."""
    columns = []
    for parameter in FREE:
        value = mechanism.value(parameter)
        up, down = (
            torque_of(mechanism.with_values({parameter: value * f}), COMMANDS[name], SAMPLES)
            for f in (1.0 + 1e-6, 1.0 - 1e-6)
        )
        columns.append((up - down) / (2e-6 * value))
    J = np.column_stack(columns)
    linear = np.column_stack((np.ones(SAMPLES), np.arange(SAMPLES)))
    J -= linear @ np.linalg.lstsq(linear, J, rcond=None)[0]
    return J.T @ J / SIGMA[name] ** 2


def test_shares_and_factors_are_those_of_the_fisher_matrices(made):
    found = record_information(*made)
    fishers = [fisher_by_differences(name, made[1].mechanism) for name in NAMES]
    total = sum(fishers)
    sigma = np.sqrt(np.diag(np.linalg.inv(total)))
    assert (found.parameters, found.records) == (FREE, NAMES)
    share = np.column_stack([np.diag(F) / np.diag(total) for F in fishers])
    assert found.share == pytest.approx(share, rel=1e-3)
    for factor, sign in ((found.without, -1.0), (found.repeated, 1.0)):
        expected = np.column_stack([np.sqrt(np.diag(np.linalg.inv(total + sign * F))) / sigma for F in fishers])
        assert factor == pytest.approx(expected, rel=1e-3)
    assert np.all(found.without >= 1.0)
    assert np.all(found.repeated <= 1.0)


def test_the_only_record_cannot_be_missing(made):
    of, fit = made
    found = record_information(replace(of, records=of.records[:1]), fit)
    assert np.all(np.isinf(found.without))
    assert found.share == pytest.approx(np.ones((2, 1)))
    assert found.repeated == pytest.approx(np.full((2, 1), np.sqrt(0.5)))


def test_nothing_free_tells_nothing(made):
    of, fit = made
    assert record_information(of, replace(fit, parameters={})) is None


def test_the_resonances_are_the_papers():
    """Section 5.1 of the paper: 46.9 Hz estimated, 72.7 Hz nominal; 5578 rad/s in hertz."""
    found = {r.name: r.frequency_hz for r in resonances(truth())}
    assert found["load on the gear"] == pytest.approx(46.9, abs=0.05)
    assert found["housing"] == pytest.approx(5578.0 / 6.283185, rel=1e-6)
