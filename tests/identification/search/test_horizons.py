"""How far a model follows records. Truth: the mechanism that made them, spoilt samples; and what is read, counted."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.search.first_moments import first_residual, first_window
from mechid.identification.search.horizons import (
    chance_limit,
    followed_samples,
    gate_window,
    horizon,
    horizons_at,
    least_horizons,
    unfollowed_records,
)
from mechid.identification.search.settings import SEARCH
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


def problem_of(*names, seconds):
    """Return the problem of records made by the truth, which begins 2 and 10 % away from it."""
    return make_problem(bench(displaced(truth(), FREE), truth(), *names, seed=6, seconds=seconds), 1)


def test_starts_and_horizons_read_what_they_use():
    """Truth: the first 60 ms; for a model that loses the record at once the gate and two pieces of simulation."""
    problem = problem_of("full_46", "micro_46", seconds=1.0)
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


def test_a_record_is_followed_up_to_the_window_that_is_spoilt():
    """Truth: 30 samples that were moved by a hundred times the noise, from sample 1520 on."""
    problem = problem_of("full_46", "micro_46", seconds=0.3)
    q = problem.coordinates.point({name: truth().value(name) for name in FREE})
    assert unfollowed_records(problem, q) == []
    target = problem.targets[0]
    spoilt = np.array(target.leading.measured)
    spoilt[1520:1550] += 0.2
    problem = replace(problem, targets=(with_leading(target, measured=spoilt), *problem.targets[1:]))
    assert unfollowed_records(problem, q) == ["full_46"]
    found = followed_samples(problem, problem.targets[0], q)
    assert 1520 - gate_window(target) < found <= 1520
    whole, least = {t.name: t.samples for t in problem.targets}, least_horizons(problem)
    assert horizons_at(problem, q, whole, least) == {"full_46": found, "micro_46": whole["micro_46"]}
    gates = {name: n // 8 for name, n in whole.items()}
    assert horizons_at(problem, q, gates, least)["full_46"] <= 2 * gates["full_46"], "twice the gate at most"


def test_a_window_of_noise_is_no_misfit_by_chance():
    """Truth: the mean square of white noise, over as many windows as a long campaign has."""
    problem = problem_of("full_46", seconds=0.3)
    window = gate_window(problem.targets[0])
    noise = np.random.default_rng(4).standard_normal((100_000, window))
    assert 1.5 < np.mean(noise**2, axis=1).max() < chance_limit(problem) < SEARCH.gate_limit + 1.0


@pytest.mark.parametrize("name", ["full_46", "micro_46"])
def test_a_horizon_is_never_less_than_the_first_moments(name):
    """Truth: 15 ms, or one window past the first motion."""
    problem = problem_of(name, seconds=0.1)
    target = problem.targets[0]
    least = least_horizons(problem)[name]
    assert least >= round(SEARCH.floor_s * target.base.sample_rate_hz)
    far = problem.coordinates.lower
    assert horizons_at(problem, far, {name: least}, {name: least})[name] >= least
