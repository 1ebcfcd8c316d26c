"""Lines of tooth meshes, whose period does not fit the steps, against direct simulations of the whole mechanism."""

import numpy as np
import pytest

from layouts import changed, mechanism_of, paper_table
from mechid.budgets.incommensurate import map_period
from mechid.budgets.indices import Index
from mechid.budgets.named_lines import line_names
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.pointing_error import Instants, Source
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.plant.flight import to_flight, with_line_filter
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

RATE = 40.0
MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(RATE))
MODE = OperatingMode(name="m", command=MICRO, rates=np.array([RATE]), highest_hz=100.0)
ERRORS = [
    {"order": "mesh 1", "amplitude": 2e-5, "phase_deg": 20.0},
    {"order": "mesh 2", "amplitude": 1e-5, "phase_deg": -70.0},
]
VARIATION = [{"order": "mesh 2", "amplitude": 0.02, "phase_deg": 100.0}]
MESHES = [{"teeth": [71, 69]}, {"teeth": [73, 80], "ratio_behind": 50.0 * 71.0 * 73.0 / (69.0 * 80.0)}]
"""71 a turn repeats after 5 s at this rate, 75.1 a turn never within 2000 steps."""


def flying(scale=1.0, **parts):
    """Return the paper's mechanism as it flies, with two meshes and imperfections of a scale."""
    gear = {"mesh": MESHES, "kinematic_error": ERRORS, "stiffness_variation": VARIATION} | parts
    for entry in ("kinematic_error", "stiffness_variation"):
        gear[entry] = [{**one, "amplitude": min(scale * one["amplitude"], 1.0)} for one in gear[entry]]
    return to_flight(mechanism_of(changed(paper_table(), {"housing": None, "gear": gear})))


def direct(mechanism, frequency_hz, seconds=12.0, settled_s=2.0):
    """Return the amplitudes of lines by least squares over a long simulation of the whole mechanism."""
    base = TimeBase(4_000.0, round(seconds * 4_000.0) + 1)
    y = simulate_run(Simulator(mechanism.plant, MICRO, base).run(mechanism.kernel_values())).torque
    y = y[round(settled_s * 4_000.0) :]
    count = 2 * frequency_hz.size + 1
    normal, right = np.zeros((count, count)), np.zeros(count)
    for k in range(0, y.size, 4_000):
        angle = 2.0 * np.pi / 4_000.0 * np.outer(np.arange(k, min(k + 4_000, y.size)), frequency_hz)
        rows = np.hstack([np.cos(angle), np.sin(angle), np.ones((len(angle), 1))])
        # Hann's window keeps lines above the mode's highest frequency out.
        weighted = rows * np.sin(np.pi * np.arange(k, k + len(angle)) / y.size)[:, None] ** 2
        normal += weighted.T @ rows
        right += weighted.T @ y[k : k + 4_000]
    found = np.linalg.solve(normal, right)
    return np.hypot(found[: frequency_hz.size], found[frequency_hz.size : -1])


@pytest.mark.slow
def test_lines_are_those_of_a_long_run(note):
    """Truth: least squares over 10 s of the whole mechanism."""
    mechanism = flying()
    state = steady_state(mechanism, MODE, RATE, (), 2)
    assert state.periods == 1
    own = ~state.is_periodic
    expected = direct(mechanism, state.frequency_hz)
    off = np.abs(np.abs(state.lines) - expected)
    note(f"mesh lines: {off[own].max() / expected[own].max():.1e} of the largest, {np.sum(own)} lines")
    assert off[own].max() < 1e-3 * expected[own].max()
    assert np.all(off[own] < 2.0 * state.error[own] + 1e-6)
    names = dict(zip(line_names(state.step_orders, mechanism), np.abs(state.lines), strict=True))
    assert names["mesh 1"] > 1e-3
    assert names["mesh 2"] > 1e-5


@pytest.mark.slow
def test_derivatives_are_those_of_differences():
    """Truth: differences over the whole steady state, to an amplitude and a phase of the mesh that does not fit."""
    mechanism = flying()
    names = ("gear.kinematic_error.0.amplitude", "gear.kinematic_error.0.phase_deg")
    state = steady_state(mechanism, MODE, RATE, names, 2)
    for k, name in enumerate(names):
        value = mechanism.value(name)
        ends = [steady_state(mechanism.with_values({name: value * s}), MODE, RATE, (), 2) for s in (1.01, 0.99)]
        kept = np.isin(state.orders, ends[0].orders) & np.isin(state.orders, ends[1].orders) & ~state.is_periodic
        lines = [end.lines[np.isin(end.orders, state.orders[kept])] for end in ends]
        slope = (lines[0] - lines[1]) / (0.02 * value)
        np.testing.assert_allclose(state.gradient[kept, k], slope, atol=1e-3 * np.abs(slope).max())


@pytest.mark.slow
def test_a_large_harmonic_counts_as_a_motion_that_does_not_repeat():
    """Truth: the linear response to a tenfold error misses more than a tenth of the torque it makes."""
    assert steady_state(flying(10.0), MODE, RATE, (), 2).periods == 0


def test_a_mechanism_that_repeats_keeps_all_harmonics():
    """Truth: mesh 1 alone, 71 a turn of 200 steps, repeats after 200."""
    errors = [one for one in ERRORS if one["order"] != "mesh 2"]
    lined = with_line_filter(flying(kinematic_error=errors, stiffness_variation=[]), 1e3)
    period = map_period(lined, MODE, RATE, (), 1)
    assert period.steps == 200
    assert period.apart == ()


def test_lines_between_the_multiples_pass_all_phases():
    """Truth: two incommensurate sines of amplitude 1 reach 2, and have the mean square 1 of both."""
    source = Source("s", 1.0, np.array([1.0, 1.0 + np.sqrt(0.5)]), np.ones((2, 1), dtype=complex))
    wave = source.waveform(Index("APE"), Instants(4096, 1, 0))[:, 0]
    assert np.max(wave) == pytest.approx(2.0, abs=0.05)
    assert np.mean(wave**2) == pytest.approx(1.0, rel=0.02)
