"""How far off records are during a search. Truth: the noise that the bench drew, the validation of a fit, a clock."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

import synthetic
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import ResidualToNoise, residual_to_noise
from mechid.simulation.interruption import interrupt_by
from synthetic import bench, displaced, truth, with_leading

NAMES = ("full_46", "micro_46")


@pytest.fixture(scope="module")
def problem():
    return make_problem(bench(displaced(truth(), {"gear.stiffness": 1.02}), truth(), *NAMES, seed=8, seconds=0.3), 1)


def test_at_the_truth_it_is_the_noise(problem):
    q = problem.coordinates.point({"gear.stiffness": truth().value("gear.stiffness")})
    floors = {(name, "torque"): synthetic.NOISE_NM for name in NAMES}
    for ratio in residual_to_noise(problem, q, floors).values():
        assert ratio == pytest.approx(1.0, abs=4.0 / math.sqrt(2.0 * 3001))


def test_elsewhere_it_is_the_residual_with_offset_and_drift_removed(problem):
    """Truth: NumPy's straight line through measured less simulated torque."""
    floors = {(name, "torque"): synthetic.NOISE_NM for name in NAMES}
    found = residual_to_noise(problem, problem.start, floors)
    assert min(found.values()) > 2.0
    for target in problem.targets:
        r = misfit_series(problem.model, target, problem.start, (0, target.samples))[0]
        k = np.arange(r.size)
        r -= np.polynomial.Polynomial.fit(k, r, 1)(k)
        assert found[target.name] == pytest.approx(float(np.sqrt(np.mean(r**2))) / synthetic.NOISE_NM, rel=1e-6)


def test_the_level_is_that_of_the_beginning_not_the_one_released(problem):
    """Truth: noise released to a thousand times as much changes no floor."""
    watched = ResidualToNoise(problem)
    before = watched.measure("joint fit", problem, problem.start)
    released = problem.with_sigmas({t.name: 1e3 * t.leading.sigma for t in problem.targets})
    assert watched.measure("noise re-estimated", released, problem.start) == pytest.approx(before)


def test_it_looks_at_each_stage_and_else_takes_its_share_of_the_time(problem, monkeypatch):
    """Truth: a clock that goes on by a second whenever it is read, so that a look takes one."""
    clock = itertools.count()
    monkeypatch.setattr("mechid.identification.stages.watch.time", SimpleNamespace(perf_counter=clock.__next__))
    watched = ResidualToNoise(problem)
    looks = [bool(watched.measure("joint fit", problem, problem.start)) for _ in range(100)]
    apart = np.diff(np.flatnonzero(looks))
    assert looks[0]
    assert set(apart.tolist()) <= {round(1.0 / STAGES.share_of_time), round(1.0 / STAGES.share_of_time) + 1}
    assert watched.measure("noise re-estimated", problem, problem.start)
    assert not watched.measure("noise re-estimated", problem, problem.start)


def test_a_simulation_that_fails_is_infinitely_far_off(problem):
    q = problem.start * math.nan
    assert set(residual_to_noise(problem, q, {}).values()) == {math.inf}


def test_what_does_not_count_is_left_out(problem):
    """Truth: a tenth of the samples spoilt and rejected leaves what the others say."""
    (target,) = problem.restrict_to(["full_46"]).targets
    spoilt = target.leading.measured.copy()
    rejected = np.arange(0, spoilt.size, 10)
    spoilt[rejected] = 1e3
    other = with_leading(target, measured=spoilt, rejected=rejected)
    problem_of = problem.restrict_to(["full_46"])
    q = problem.coordinates.point({"gear.stiffness": truth().value("gear.stiffness")})
    changed = type(problem)(problem_of.space, (other,))
    (ratio,) = residual_to_noise(changed, q, {("full_46", "torque"): synthetic.NOISE_NM}).values()
    assert ratio == pytest.approx(1.0, abs=4.0 / math.sqrt(2.0 * 2700))


def test_nobody_is_told_who_does_not_listen(monkeypatch):
    """A search without a listener does not spend its share."""
    monkeypatch.setattr(ResidualToNoise, "measure", lambda *_: pytest.fail("looked at for nobody"))
    campaign = bench(displaced(truth(), {"gear.stiffness": 1.001}), truth(), "full_46", seed=8, seconds=0.1)
    identify(campaign, workers=1, near={"gear.stiffness": truth().value("gear.stiffness")})


def test_a_look_does_not_count_among_what_a_search_is_asked(problem):
    """The clock makes looks: a search is to be ended at the same place in each run."""
    asked = []
    with interrupt_by(lambda: asked.append(1)):
        ResidualToNoise(problem).measure("joint fit", problem, problem.start)
    assert not asked
