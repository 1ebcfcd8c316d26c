"""Growth of horizons, and long records within an identification. Truth: the same campaign in memory."""

import math
from dataclasses import replace

import numpy as np
import pytest

from little_memory import little_memory  # noqa: F401
from mechid.analysis import validate
from mechid.identification.identify import identify, make_problem
from mechid.identification.search.gates import grow_horizons
from mechid.signal.stored_series import StoredSeries, as_writable
from synthetic import bench, displaced, truth

FREE = {"gear.stiffness": 1.02, "gear.damping": 0.9}


def made(seconds):
    return bench(displaced(truth(), FREE), truth(), "full_46", "micro_46", seed=6, seconds=seconds)


def in_files(campaign):
    """Return a campaign with the samples of its records in files."""
    return replace(
        campaign,
        records=tuple(
            replace(
                r, data=replace(r.data, channels=tuple(replace(c, data=as_writable(c.data)) for c in r.data.channels))
            )
            for r in campaign.records
        ),
    )


@pytest.fixture
def both(little_memory, monkeypatch):  # noqa: F811
    """Return fit and validation of a campaign from files and from memory."""
    campaign = in_files(made(0.3))
    assert all(isinstance(c.data, StoredSeries) for r in campaign.records for c in r.data.channels)
    fit = identify(campaign, workers=1)
    long = fit, validate(campaign, fit)
    monkeypatch.undo()
    campaign = made(0.3)
    fit = identify(campaign, workers=1)
    return long, (fit, validate(campaign, fit))


def test_an_identification_from_files_is_that_from_memory(both):
    """Truth: the twin in memory; levels are told from fewer segments, so that weights differ by percents."""
    (long, validated), (short, expected) = both
    assert (long.outcome, long.grade) == (short.outcome, short.grade)
    for name in FREE:
        one, other = long.parameters[name], short.parameters[name]
        assert abs(one.value - other.value) < 0.1 * other.std_error
        assert one.std_error == pytest.approx(other.std_error, rel=0.05)
    for name, record in short.records.items():
        assert long.records[name].residual_rms == pytest.approx(record.residual_rms, rel=1e-3)
        assert long.records[name].horizon_s == record.horizon_s
        one, other = validated[name].channels["torque"], expected[name].channels["torque"]
        assert one.samples_sha256 == other.samples_sha256
        assert one.fit_percent == pytest.approx(other.fit_percent, abs=0.01)
        assert one.whiteness.statistic == pytest.approx(other.whiteness.statistic, rel=0.01)
        assert one.effective_samples == pytest.approx(other.effective_samples, rel=1e-3)
        np.testing.assert_allclose(one.residual_density, other.residual_density, rtol=0.05)


def test_a_growth_that_stalls_leaps_as_often_as_it_may(monkeypatch):
    """Truth: a leap made by hand, which leads to the mechanism that made the record; the growth goes on from there."""
    names = (*FREE, "friction.coulomb", "stepper.torque_constant", "housing.frequency")
    problem = make_problem(bench(truth().with_free(names), truth(), "full_23", "full_46", seed=6, seconds=0.5), 1)
    right, rng = problem.start, np.random.default_rng(2)
    away = {name: truth().value(name) * math.exp(0.25 * rng.standard_normal()) for name in names}
    far = problem.coordinates.clip(problem.coordinates.point(away))
    leapt = []

    def lead(_problem, q, gates, *_):
        leapt.append(q)
        return (right, {name: n + 1 for name, n in gates.items()}) if len(leapt) == 2 else None

    monkeypatch.setattr("mechid.identification.search.gates.leap", lead)
    monkeypatch.setattr("mechid.identification.search.gates.retreat", lambda *_: None)
    for leaps, complete in ((0, False), (1, False), (2, True)):
        leapt.clear()
        grown = grow_horizons(problem, far, np.random.default_rng(1), escapes=0, leaps=leaps)
        assert grown.complete is complete
        assert len(leapt) == leaps
    assert grown.horizons == {"full_23": 5001, "full_46": 5001}
