"""Long records within an identification. Truth: the same campaign in memory; and what is read of a record, counted."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from little_memory import little_memory  # noqa: F401
from mechid.analysis import validate
from mechid.identification.identify import identify, make_problem
from mechid.identification.search.first_moments import first_residual, first_window
from mechid.identification.search.horizons import gate_window, horizon, least_horizons
from mechid.identification.search.settings import SEARCH
from mechid.signal.stored import Stored, room_of
from synthetic import bench, displaced, truth, with_leading

FREE = {"gear.stiffness": 1.02, "gear.damping": 0.9}


@dataclass
class Read:
    """A series that knows how far it was read."""

    samples: np.ndarray
    stops: list = field(default_factory=list)

    @property
    def size(self):
        return self.samples.size

    def __getitem__(self, part):
        self.stops.append(part.indices(self.size)[1])
        return self.samples[part]


def made(seconds):
    return bench(displaced(truth(), FREE), truth(), "full_46", "micro_46", seed=6, seconds=seconds)


def in_files(campaign):
    """Return a campaign with the samples of its records in files."""
    return replace(
        campaign,
        records=tuple(
            replace(r, data=replace(r.data, channels=tuple(replace(c, data=room_of(c.data)) for c in r.data.channels)))
            for r in campaign.records
        ),
    )


def test_starts_and_horizons_read_what_they_use():
    """Truth: the first 60 ms; for a model that loses the record at once the gate and two pieces of simulation."""
    problem = make_problem(made(1.0), 1)
    target = problem.targets[0]
    read = Read(target.leading.measured)
    watched = with_leading(target, measured=read)
    first_residual(problem, watched, problem.start)
    assert max(read.stops) == first_window(target)[1]
    read.stops.clear()
    far = problem.start + 0.5 * (problem.coordinates.upper - problem.start)
    gate = least_horizons(problem)[target.name]
    found = horizon(problem, watched, far, gate, 0)
    assert found < 2 * gate
    assert max(read.stops) <= max(gate, found + gate_window(target)) + 2 * SEARCH.short_block < target.samples / 2


@pytest.fixture
def both(little_memory, monkeypatch):  # noqa: F811
    """Return fit and validation of a campaign from files and from memory."""
    campaign = in_files(made(0.3))
    assert all(isinstance(c.data, Stored) for r in campaign.records for c in r.data.channels)
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
