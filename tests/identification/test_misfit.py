"""One residual with one sign, and what a reader is told of the other one."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.identification.output_error.misfit import JUMP, Misfit, misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.record_fit import record_fit
from synthetic import COMMANDS, RATE_HZ, displaced, record, truth

OFFSET, DRIFT = 0.3, -2.0
"""N m and N m/s that the record has beside the model; no noise."""
SAMPLES = 2501
"""More than two of the simulator's blocks with sensitivities."""
WINDOW = (1000, 2311)


@pytest.fixture(scope="module")
def made():
    """Return a record that is the model's own torque and a line, the line, the problem and its target."""
    problem = Problem(SearchSpace(displaced(truth(), {"gear.stiffness": 1.0})), ())
    line = OFFSET + DRIFT * np.arange(SAMPLES) / RATE_HZ
    alone = target_of(record("full_46", np.zeros(SAMPLES), COMMANDS["full_46"]))
    own = record("full_46", problem.model.predict(alone, problem.start, SAMPLES)[0] + line, COMMANDS["full_46"])
    return own, line, problem, target_of(own)


def test_the_misfit_is_model_less_measured(made):
    """Truth: what was added to the model's own torque, with the other sign; a window is that part of the whole."""
    _, line, problem, target = made
    (r,) = misfit_series(problem.model, target, problem.start, (0, SAMPLES))
    np.testing.assert_allclose(r, -line, atol=1e-13)
    (part,) = misfit_series(problem.model, target, problem.start, WINDOW)
    np.testing.assert_array_equal(part, r[slice(*WINDOW)])


def test_pieces_of_a_window_join_to_it_with_their_derivatives(made):
    """Truth: the series of the window, and central differences of it."""
    _, _, problem, target = made
    rows = np.full((2, WINDOW[1] - WINDOW[0]), np.nan)
    for piece in Misfit(problem.model, target, problem.start, WINDOW, jacobian=True):
        here = slice(piece.first - WINDOW[0], piece.stop - WINDOW[0])
        piece.residual(0, rows[0, here])
        piece.write_slopes(0, rows[1:, here])
    (r,) = misfit_series(problem.model, target, problem.start, WINDOW)
    np.testing.assert_allclose(rows[0], r, atol=1e-13)
    ahead, behind = (misfit_series(problem.model, target, problem.start + s, WINDOW)[0] for s in (1e-5, -1e-5))
    np.testing.assert_allclose(rows[1], (ahead - behind) / 2e-5, atol=1e-5 * np.abs(rows[1]).max())


def test_a_reader_is_told_what_the_measured_has_beside_the_model(made):
    """Truth: measured = model + offset + drift t, as the record was made."""
    own, _, problem, _ = made
    told = record_fit(own, problem, problem.start, {})
    assert told.offset == pytest.approx(OFFSET, rel=1e-9)
    assert told.drift == pytest.approx(DRIFT, rel=1e-9)
    assert told.residual_rms < 1e-12


def test_a_sample_in_whose_interval_the_model_jumps_counts_as_the_one_before_it():
    """Truth: the noise that was added, that of the sample before where a recorder shows 1 N m more at each impact."""
    geared = mechanism_of(changed(paper_table(), LAYOUTS["backlash"]))
    problem = Problem(SearchSpace(displaced(geared, {"gear.stiffness": 1.0})), ())
    alone = target_of(record("full_46", np.zeros(SAMPLES), COMMANDS["full_46"]))
    noise = 1e-3 * np.random.default_rng(5).standard_normal(SAMPLES)
    torque = problem.model.predict(alone, problem.start, SAMPLES)[0] + noise
    target = target_of(record("full_46", torque, COMMANDS["full_46"]))
    sigma, jumped = target.leading.sigma, []
    for block in problem.model.run(target, problem.start, SAMPLES).blocks():
        jumped += (block.start + block.jumps.beyond(JUMP * sigma, 0)).tolist()
    assert len(jumped) >= 20
    spoilt = torque.copy()
    spoilt[jumped] += 1.0
    shown = replace(target, channels=(replace(target.leading, measured=spoilt),))
    (r,) = misfit_series(problem.model, shown, problem.start, (0, SAMPLES))
    clear = np.setdiff1d(np.arange(SAMPLES), jumped)
    np.testing.assert_allclose(r[clear], -noise[clear], atol=1e-12)
    before = clear[np.searchsorted(clear, jumped) - 1]
    np.testing.assert_allclose(r[jumped], -noise[before], atol=1e-12)
