"""Records that begin off rest: in motion, wound up, with currents of their own."""

import numpy as np
import pytest

from layouts import LAYOUTS, paper_with
from mechid.kernel.start import off_rest
from mechid.simulation.simulator import Simulator
from mechid.simulation.start import Start, states_in
from paper import constant
from runs import base, run_kernel

COMMAND = constant(46.0)
OFF = {
    "start.angle": 0.01,
    "start.rate": 3.0,
    "start.twist": 0.5e-4,
    "start.twist_rate": 0.02,
    "start.current_a": 0.05,
    "start.current_b": -0.03,
    "start.housing": 0.1,
    "start.housing_rate": -0.05,
    "start.transducer": 0.2,
    "start.transducer_rate": -0.1,
    "start.charge_amplifier": 0.3,
    "start.mode_1": 1e-4,
    "start.mode_1_rate": 0.02,
    "start.mode_2": -1e-4,
    "start.mode_2_rate": 0.05,
    "start.bristle": 1e-6,
}
"""Inside the play of the layout with backlash: at its edge, 0.1 mrad, the torque jumps and has no derivative."""
LANES = 32
CHAIN = {**LAYOUTS["load_dependent"], **LAYOUTS["kinematic_error"], **LAYOUTS["test stand"]}


def torque(mechanism, start, *, command=COMMAND, time_base=None, p=None, directions=None):
    """Return the torque of a run, and its derivatives along the directions and lanes."""
    p = mechanism.kernel_values() if p is None else p
    none = np.zeros((p.size, 0))
    made = Simulator(mechanism.plant, command, time_base or base(0.06), capacity=LANES, start=start)
    run = made.run(p, substeps=8, directions=none if directions is None else directions)
    blocks = [(b.y[:, 0].copy(), b.jacobian[:, 0].copy()) for b in run.blocks()]
    return np.concatenate([y for y, _ in blocks]), np.concatenate([J for _, J in blocks])


@pytest.mark.slow
@pytest.mark.parametrize(
    "layout",
    [
        {},
        pytest.param(CHAIN, marks=pytest.mark.slow),
        *(pytest.param(LAYOUTS[n], marks=pytest.mark.slow) for n in ("lugre", "flexible load", "backlash")),
    ],
)
def test_derivatives_to_the_start_and_to_parameters_behind_it(layout):
    """Truth: central differences, across switches; where one passes a sample a difference is no derivative."""
    m = paper_with(layout)
    values = {key: OFF.get(key, 0.05) for key in m.plant.starts}
    lanes = {key: 2 + k for k, key in enumerate(values)}
    moved = [list(map(str, m.plant.parameters)).index(name) for name in ("L", "G")]
    directions = np.zeros((len(m.plant.parameters), 2 + len(values)))
    directions[moved[0], 0] = 1.0
    if "e_c1" in map(str, m.plant.parameters):
        directions[list(map(str, m.plant.parameters)).index("e_c1"), 1] = 1.0
    _, J = torque(m, Start(values, {lane: {key: 1.0} for key, lane in lanes.items()}), directions=directions)
    for key, value in values.items():
        step = 1e-5 * max(abs(value), 1e-3)
        up, down = (torque(m, Start({**values, key: value + way * step}))[0] for way in (1, -1))
        _assert_slope((up - down) / (2 * step), J[:, lanes[key]], key)
    for lane in np.flatnonzero(directions[:, :2].any(axis=0)):
        p, direction = m.kernel_values(), directions[:, lane]
        step = 1e-5 * (np.abs(p @ direction) or 1e-3)
        up, down = (torque(m, Start(values), p=p + way * step * direction)[0] for way in (1, -1))
        _assert_slope((up - down) / (2 * step), J[:, lane], str(lane))


def _assert_slope(difference, slope, what):
    off = np.abs(difference - slope) > 1e-4 * np.abs(difference).max()
    assert off.sum() <= 5, what


@pytest.mark.parametrize("rate", [46.0, -46.0])
@pytest.mark.parametrize("begun_s", [0.0371, 4.0 / 46.0])
def test_a_run_begun_in_motion_goes_on_as_the_whole_one(rate, begun_s):
    """Truth: the run from rest; the other begins in its states, between two steps or on one."""
    m, command = paper_with(CHAIN), constant(rate)
    until = base(begun_s, rate_hz=1.0 / begun_s)
    before = Simulator(m.plant, command, until, capacity=LANES).run(m.kernel_values(), substeps=2048)
    for _ in before.blocks():
        pass
    later, rest = command.begin_at(begun_s), base(0.05, start_s=begun_s)
    initial = later.excitation(0.05).initial
    reached = states_in(before.simulator.kernel, before.buffers)
    own = off_rest(m.plant, m.kernel_values(), initial, later.start_angle_rad, reached)
    whole = run_kernel(m, command, rest, substeps=8, lanes=LANES).torque
    assert len(m.plant.starts) > 8
    np.testing.assert_allclose(
        torque(m, Start(own), command=later, time_base=rest)[0], whole, rtol=0, atol=2e-6 * np.abs(whole).max()
    )


@pytest.mark.slow
def test_a_held_rotor_stops_at_once_and_its_load_does_not():
    """Truth: differences: friction takes a small rate from the rotor, the load behind the gear keeps its part.

    What the stop itself knocks out of the housing no derivative has; it has died away after 20 ms.
    """
    m = paper_with({"friction": {"static": 0.5, "coulomb": 0.5}})
    values, step = {"start.rate": 0.0, "start.twist": 1e-4}, 1e-5
    _, J = torque(m, Start(values, {0: {"start.rate": 1.0}}), directions=np.zeros((len(m.plant.parameters), 1)))
    up, down = (torque(m, Start({**values, "start.rate": way * step}))[0] for way in (1, -1))
    _assert_slope(((up - down) / (2 * step))[200:], J[200:, 0], "rate")
