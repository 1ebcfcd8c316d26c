"""One residual with one sign, and what a reader is told of the other one."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.identification.output_error import misfit
from mechid.identification.output_error.misfit import Misfit, misfit_series, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.record_fit import record_fit
from mechid.kernel.batch.source import SETS
from mechid.simulation.batch import Batch
from mechid.simulation.simulator import BLOCK
from mechid.simulation.work import RUNS_A_BATCH, work_counter, work_of_run
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


@pytest.mark.parametrize("is_short", [True, False])
def test_runs_of_a_short_window_are_simulated_alone_and_counted_as_in_a_batch(made, is_short, monkeypatch):
    """Truth: the work of eight runs by its formula, a quarter of it in a batch; the misfit of each run by itself."""
    _, _, problem, target = made
    fewest = target.samples + 1 if is_short else 1
    monkeypatch.setattr(misfit, "PROBLEM", replace(misfit.PROBLEM, shortest_in_batch=fewest))
    batches = []
    monkeypatch.setattr(misfit, "Batch", lambda runs: batches.append(runs) or Batch(runs))
    window, points = (0, target.samples), [problem.start + 1e-3 * k for k in range(SETS)]
    with work_counter() as work:
        together = misfit_series_of(problem.model, target, points, window)
    assert bool(batches) is not is_short
    p = len(problem.space.mechanism.plant.parameters)
    assert work.done == pytest.approx(
        work_of_run(SETS * target.samples * problem.substeps, p, 0) / RUNS_A_BATCH, rel=0.01
    )
    for q, found in zip(points, together, strict=True):
        (alone,) = misfit_series(problem.model, target, q, window)
        np.testing.assert_allclose(found[0][:], alone[:], rtol=0, atol=1e-9 * np.abs(alone[:]).max())


def test_a_reader_is_told_what_the_measured_has_beside_the_model(made):
    """Truth: measured = model + offset + drift t, as the record was made."""
    own, _, problem, _ = made
    told = record_fit(own, problem, problem.start, {})
    assert told.offset == pytest.approx(OFFSET, rel=1e-9)
    assert told.drift == pytest.approx(DRIFT, rel=1e-9)
    assert told.residual_rms < 1e-12


@pytest.fixture(scope="module", params=["backlash", pytest.param("output_friction", marks=pytest.mark.slow)])
def jumping(request):
    """Return a problem whose torque jumps, a target with noise of 1 mN m, that noise, and samples, shares, rises."""
    mechanism = mechanism_of(changed(paper_table(), LAYOUTS[request.param]))
    problem = Problem(SearchSpace(displaced(mechanism, {"gear.stiffness": 1.0})), ())
    alone = target_of(record("full_46", np.zeros(SAMPLES), COMMANDS["full_46"]))
    noise = 1e-3 * np.random.default_rng(5).standard_normal(SAMPLES)
    torque, jumps = problem.model.predict(alone, problem.start, SAMPLES)[0] + noise, []
    for block in problem.model.run(alone, problem.start, SAMPLES).blocks():
        own = block.jumps
        jumps += list(zip(block.start + own.samples, own.since, own.rises[:, 0], strict=True)) if own.since.size else []
    return problem, target_of(record("full_46", torque, COMMANDS["full_46"])), noise, jumps


def test_samples_at_a_jump_count_by_what_a_recorder_may_make_of_it(jumping):
    """Truth: the noise that was added, at jumps by hand: 1/sqrt(1 + (5 share rise/sigma)^2), then those about."""
    problem, target, noise, jumps = jumping
    (r,) = misfit_series(problem.model, target, problem.start, (0, SAMPLES))
    variance = np.zeros(SAMPLES)
    for at, since, rise in jumps:
        variance[at - 1] += (5.0 * since * rise / target.leading.sigma) ** 2
        variance[at] += (5.0 * (1.0 - since) * rise / target.leading.sigma) ** 2
    high = variance > 1.0
    assert np.count_nonzero(high) > 20
    weight = 1.0 / np.sqrt(1.0 + variance)
    shifts = (-2, -1, 1, 2)
    about = sum(np.roll(weight**2 * noise, k) for k in shifts) / sum(np.roll(weight**2, k) for k in shifts)
    expected = -(weight * noise + (1.0 - weight) * about)
    place = np.arange(SAMPLES) % BLOCK
    inner = high & (place > 2) & (place < BLOCK - 3)
    np.testing.assert_allclose(r[inner], expected[inner], atol=1e-9)
    np.testing.assert_allclose(r[variance == 0.0], -noise[variance == 0.0], atol=1e-12)


def test_a_recorder_without_a_filter_is_followed(jumping):
    """Truth: the noise, where the record has the value at the sample's instant, of which the model has the mean."""
    problem, target, noise, jumps = jumping
    shown = target.leading.measured.copy()
    for at, since, rise in jumps:
        shown[at] += (1.0 - since) * rise
    assert np.std(shown - target.leading.measured + noise) > 1.3 * np.std(noise)
    other = replace(target, channels=(replace(target.leading, measured=shown),))
    (r,) = misfit_series(problem.model, other, problem.start, (0, SAMPLES))
    assert np.std(r) < 1.03 * np.std(noise)


def test_the_cost_is_continuous_where_a_jump_passes_a_sample(jumping):
    """Truth: steps of a five-hundredth of the sample interval change the sum of squares by little, over two samples."""
    problem, target, _, _ = jumping
    costs = []
    for offset_s in np.linspace(0.0, 2.0 / RATE_HZ, 1001):
        moved = target.with_time_offset(replace(target.time_offset, value=offset_s))
        (r,) = misfit_series(problem.model, moved, problem.start, (0, SAMPLES))
        costs.append(float(np.sum(np.square(r))) / target.leading.sigma**2)
    assert np.max(np.abs(np.diff(costs, 2))) < 0.01 * np.ptp(costs)


def test_a_model_with_jumps_leaves_the_noise(jumping):
    """Truth: draws of noise leave n - 2 variances behind offset and drift, not several per cent fewer."""
    problem, target, noise, _ = jumping
    clean = target.leading.measured - noise
    rng, sigma = np.random.default_rng(8), target.leading.sigma
    drawn = [
        replace(target, channels=(replace(target.leading, measured=clean + sigma * rng.standard_normal(SAMPLES)),))
        for _ in range(60)
    ]
    windows = {target.name: (0, SAMPLES)}
    costs = [replace(problem, targets=(one,)).total_norm(problem.start, windows) ** 2 for one in drawn]
    assert np.mean(costs) == pytest.approx(SAMPLES - 2, abs=4.0 * np.sqrt(2.0 * SAMPLES / len(drawn)))
    full = replace(problem, targets=drawn[:1]).triangle(drawn[0], problem.start, windows[target.name])
    assert full.cost == pytest.approx(costs[0], rel=1e-9)
