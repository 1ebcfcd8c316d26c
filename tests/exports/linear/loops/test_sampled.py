"""Sampled systems. Truth: the continuous equations integrated between the instants at which inputs change."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mechid.exports.linear.loops.sampled import Sampled, close, hold, lift, series
from mechid.exports.linear.state_space import Matrices

T = 0.01
PLANT = Matrices(
    np.array([[-3.0, 40.0, 0.0], [-40.0, -5.0, 1.0], [0.0, 2.0, -20.0]]),
    np.array([[1.0, 0.0], [0.0, 3.0], [5.0, 1.0]]),
    np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0]]),
    np.array([[0.0, 0.5], [0.7, 0.0]]),
)
INPUTS, OUTPUTS = ("v", "w"), ("y", "z")


def run(system, u):
    """Return the outputs of a sampled system from rest, (n, n_y)."""
    A, B, C, D = system.matrices.all
    x, out = np.zeros(len(A)), []
    for now in u:
        out.append(C @ x + D @ now)
        x = A @ x + B @ now
    return np.array(out)


def integrated(u, delay_s):
    """Return the outputs at the samples; the first input acts late, and the new values from each instant on."""
    times = [k * T + late for k in range(len(u)) for late in (0.0, delay_s)]
    changes = np.unique(np.round(times, 12)).tolist()

    def acting(t):
        late, now = int(np.floor((t - delay_s) / T + 1e-9)), int(np.floor(t / T + 1e-9))
        return np.array([u[late, 0] if late >= 0 else 0.0, u[min(now, len(u) - 1), 1]])

    x, t, out, samples = np.zeros(3), 0.0, [], [k * T for k in range(len(u))]
    for until in changes:
        if until - t > 1e-12:
            held = acting(t)
            flow = solve_ivp(lambda _, x: PLANT.A @ x + PLANT.B @ held, (t, until), x, rtol=1e-11, atol=1e-13)  # noqa: B023
            x, t = flow.y[:, -1], until
        if any(abs(until - sample) < 1e-12 for sample in samples):
            # At an instant that is a sample and a change, the new value acts already.
            out.append(PLANT.C @ x + PLANT.D @ acting(until))
    return np.array(out[: len(u)])


@pytest.mark.parametrize("samples", [0.0, 0.4, 1.0, 2.0, 2.7])
def test_a_held_late_input_is_sampled_exactly(samples):
    u = np.random.default_rng(3).normal(size=(12, 2))
    held = hold(PLANT, INPUTS, OUTPUTS, T, delayed=("v",), delay_s=samples * T)
    assert len(held.matrices.A) == 3 + int(np.ceil(samples))
    np.testing.assert_allclose(run(held, u), integrated(u, samples * T), rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("delay", [0, 1, 3, 4, 6])
def test_a_lifted_system_is_the_fast_one_at_every_third_sample(delay):
    """Truth: the fast system, whose inputs are repeated, and the late one shifted."""
    fast = hold(PLANT, INPUTS, OUTPUTS, T)
    u = np.random.default_rng(5).normal(size=(7, 2))
    each = np.repeat(u, 3, axis=0)
    each[:, 0] = np.concatenate([np.zeros(delay), each[:, 0]])[: len(each)]
    slow = lift(fast, 3, delayed=("v",), delay=delay)
    assert slow.period_s == pytest.approx(3.0 * T)
    np.testing.assert_allclose(run(slow, u), run(fast, each)[::3], atol=1e-12)


def test_a_closed_loop_is_the_recursion_typed_out():
    """Truth: controller and plant stepped one after the other."""
    plant = Matrices(PLANT.A, PLANT.B, PLANT.C, np.array([[0.0, 0.0], [0.7, 0.0]]))
    held = hold(plant, INPUTS, OUTPUTS, T, delayed=("v",), delay_s=T)
    pi = Sampled(Matrices(np.eye(1), np.array([[0.3]]), np.eye(1), np.array([[2.3]])), T, ("y",), ("v",))
    closed = close(held, pi, ("r",))
    assert closed.inputs == ("r", "v", "w")
    assert closed.outputs == ("y", "z", "control_v")
    r, v, w = np.random.default_rng(7).normal(size=(3, 20))
    found = run(closed, np.column_stack([r, v, w]))
    A, B, C, D = held.matrices.all
    x, q = np.zeros(len(A)), 0.0
    for k in range(20):
        error = r[k] - C[0] @ x
        u = 2.0 * error + (q := q + 0.3 * error)
        acting = np.array([u + v[k], w[k]])
        np.testing.assert_allclose(found[k], [*(C @ x + D @ acting), u], atol=1e-12)
        x = A @ x + B @ acting


def test_series_and_selection_multiply_responses():
    """Truth: products of the responses at single frequencies."""
    held, hertz = hold(PLANT, INPUTS, OUTPUTS, T), [1.0, 7.0, 49.0]
    lag = Sampled(Matrices(np.array([[0.5]]), np.eye(1), np.eye(1), np.array([[0.2]])), T, ("e",), ("v",))
    chain = series(lag, held.select(("v",), ("z",)))
    expected = held.response(hertz)[:, 1, 0] * lag.response(hertz)[:, 0, 0]
    np.testing.assert_allclose(chain.response(hertz)[:, 0, 0], expected, rtol=1e-12)
    mixed = held.combine_inputs("m", [("v", 0.6), ("w", -0.8)]).response(hertz)
    np.testing.assert_allclose(mixed[:, :, 2], 0.6 * mixed[:, :, 0] - 0.8 * mixed[:, :, 1], rtol=1e-12)
