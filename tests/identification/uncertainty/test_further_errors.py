"""Errors beyond noise: bounds, held parameters and the choice of clock. Truth: the mechanism that made the records."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.result.search_state import HeldParameter
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.further_errors import consider_covariance
from synthetic import COMMANDS, bench, bounded, campaign, displaced, measured, record, truth

FREE = {"gear.stiffness": 1.002, "gear.damping": 1.02, "stepper.torque_constant": 0.998, "friction.coulomb": 1.0}
SECONDS = 0.4
MADE = ("full_46", "full_23", "micro_46")


def records_of(mechanism, seed, seconds=SECONDS, names=MADE):
    rngs = np.random.default_rng(seed).spawn(len(names))
    return [
        record(n, measured(mechanism, COMMANDS[n], rng, seconds=seconds), COMMANDS[n])
        for n, rng in zip(names, rngs, strict=True)
    ]


def at_a_bound(most):
    """Return the fit with the bound of the stiffness at a multiple of the truth."""
    stiffness = truth().value("gear.stiffness")
    start = bounded(displaced(truth(), {**FREE, "gear.stiffness": 0.7}), "gear.stiffness", max=most * stiffness)
    near = {n: start.value(n) for n in FREE} | {"gear.stiffness": most * stiffness}
    return identify(campaign(start, *records_of(truth(), 34)), near=near, workers=1)


def test_a_bound_that_excludes_the_truth_is_contradicted():
    """Truth: the mechanism that made the records, 3 % beyond the bound; the others' errors reach it all the same."""
    fit = at_a_bound(0.97)
    assert fit.parameters["gear.stiffness"].status == "at_bound"
    assert fit.parameters["gear.stiffness"].contradicted
    assert fit.parameters["gear.stiffness"].ci95 is None
    assert "standard errors beyond" in fit.parameters["gear.stiffness"].reason
    others = [fit.parameters[n] for n in FREE if n != "gear.stiffness"]
    assert all(abs(p.value - truth().value(p.name)) < 3.0 * p.std_error for p in others)
    assert max(abs(p.value - truth().value(p.name)) / p.std_error_noise for p in others) > 10.0


def test_a_bound_within_the_errors_leaves_an_interval_on_one_side():
    """Truth: the mechanism that made the records; the bound lies there, so that the optimum may be on either side."""
    fit = at_a_bound(1.0 - 2e-6)
    p = fit.parameters["gear.stiffness"]
    assert (p.status, p.contradicted) == ("at_bound", False)
    low, high = p.ci95
    assert high == pytest.approx(p.value)
    free = identify(
        campaign(displaced(truth(), FREE), *records_of(truth(), 34)),
        near={n: truth().value(n) for n in FREE},
        workers=1,
    )
    sigma = free.parameters["gear.stiffness"].std_error
    assert 0.3 * sigma < high - low < 2.5 * sigma


SHORT_S = 0.12


def test_the_consider_covariance_is_that_of_the_dense_matrices():
    """Truth: P J^T J_c s^2 J_c^T J P with J by differences of simulations, in the file's coordinates."""
    names, held, sigma = ("friction.static", "gear.stiffness"), "friction.coulomb", 2e-5
    made = bench(displaced(truth(), dict.fromkeys(names, 1.0)), truth(), "full_46", seed=53, seconds=SHORT_S)
    problem = make_problem(made, 1)
    q, windows, target = problem.start, problem.whole_windows(), problem.targets[0]
    every, slopes = problem.coordinates.value_slopes(q)
    assert every == names
    white = slopes @ covariance(problem.joint(q, windows)) @ slopes.T
    found = consider_covariance(problem, q, windows, [HeldParameter(held, 0.0, sigma, "")], names, white)

    def torque(values):
        at = replace(problem, space=SearchSpace(made.mechanism.with_values(values)))
        return at.model.predict(target, at.start, target.samples)[0]

    columns, phi = [], np.vander(np.linspace(-1.0, 1.0, target.samples), 2)
    for name in (*names, held):
        value = made.mechanism.value(name)
        h = 1e-6 * value
        columns.append((torque({name: value + h}) - torque({name: value - h})) / (2.0 * h))
    J = np.column_stack(columns)
    J = (J - phi @ np.linalg.lstsq(phi, J, rcond=None)[0]) / target.leading.sigma
    J, J_c = J[:, :2], J[:, 2]
    moved = np.linalg.solve(J.T @ J, J.T @ J_c) * sigma
    np.testing.assert_allclose(found, np.outer(moved, moved), rtol=2e-3)
