"""Lines of the torque without aliases, against long simulations at many times their sample rate."""

import numpy as np
import pytest

from flown import CASES, COMMANDS, compared, simulated
from layouts import changed, mechanism_of, paper_table
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.settings import MOTION
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.plant.flight import CUT_OFF, to_flight, with_line_filter
from mechid.plant.mechanisms import LINE_ORDER
from mechid.plant.test_stand import anti_alias_response
from mechid.simulation.linearisation import held_inputs, linearise, rotor_held
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

SLEW = Command(stepping="full", microsteps=1, rate=RateProfile.constant(92.0), start_angle_deg=45.0)
SCAN = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(47.5))


def state_of(flying, command, rate, **changes):
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]), **changes)
    return steady_state(flying.mechanism, mode, rate, (), enough_substeps(flying.mechanism, mode))


@pytest.mark.parametrize(
    ("command", "rate", "order", "was"), [(SLEW, 92.0, 5.0, 6.973e-4), (SCAN, 47.5, 10.0, 4.10e-7)]
)
def test_lines_are_not_those_that_fold_back(flying, command, rate, order, was):
    """Truth: 4 s at 37 and 74 times the rate at which these lines were off by 0.8 % and by four orders."""
    state = state_of(flying, command, rate)
    k = int(np.flatnonzero(np.isclose(state.step_orders, order))[0])
    coarse, fine = (sampled_line(flying, command, rate, order, each) for each in (7360, 14720))
    truth = abs(2.0 * fine - coarse)  # what a sample that holds a jump leaves goes with its length
    assert abs(state.lines[k]) == pytest.approx(truth, rel=3e-5, abs=2.0 * state.error[k] + 1e-12)
    assert abs(was - truth) > 5e-3 * truth  # what 10 kHz made of it
    assert state.error.max() <= 2.0 * MOTION.promised * np.abs(state.lines).max()


def sampled_line(flying, command, rate, order, each):
    """Return a line of the last 20 electrical periods of 4 s, of so many samples each."""
    base = TimeBase(0.25 * each * rate, round(each * rate) + 1)
    torque = simulate_run(Simulator(flying.mechanism.plant, command, base).run(flying.mechanism.kernel_values())).torque
    last = torque[-20 * each - 1 : -1]
    return 2.0 / last.size * np.fft.rfft(last)[round(20 * 4 * order)]


def test_the_filter_s_response_is_that_of_its_block(flying):
    """Truth: the block's own matrices, A and B as the time loop has them."""
    lined = with_line_filter(flying.mechanism, 3000.0)
    plant, f = lined.plant, np.array([10.0, 300.0, 477.5, 900.0])
    system, by_value = plant.filter, dict(zip(plant.parameters, lined.kernel_values(), strict=True))
    A = np.array(system.A.subs(by_value).tolist(), dtype=float)
    B = np.array(system.B.subs(by_value).tolist(), dtype=float).sum(axis=1)
    last = [str(s) for s in system.states].index(str(plant.outputs["torque_below_cut_off"]))
    own = [np.linalg.solve(2j * np.pi * x * np.eye(len(A)) - A, B)[last] for x in f]
    ours = anti_alias_response(LINE_ORDER, lined.value(CUT_OFF), f)
    np.testing.assert_allclose(ours / ours[0], np.array(own) / own[0], rtol=1e-9)
    assert rotor_held(plant)
    assert linearise(plant, lined.kernel_values(), held_inputs(plant), 0.0, rotor_held(plant)).states[-1] == "x_l8"


QUICK = (("paper", "full"),)
PAIRS = [
    (name, stepping) if (name, stepping) in QUICK else pytest.param(name, stepping, marks=pytest.mark.slow)
    for name in CASES
    for stepping in COMMANDS
]


@pytest.mark.parametrize(("name", "stepping"), PAIRS)
def test_what_flies_is_what_is_simulated(name, stepping):
    """Truth: `simulate` of the bench's file without housing, 12 s at 0.8 and 1.6 MHz; docs/budget.md has the table."""
    found = compared(name, stepping)
    if not found.periods:
        assert found.rms_off < 4.0 * found.state.rms_error / found.rms + 0.02
        return
    assert found.off.size > 0
    assert found.off.max() < 1e-4
    assert found.rms_off < 1e-4


@pytest.mark.slow
def test_what_never_repeats_is_right_to_its_sampling_error():
    """Truth: 60 s simulated at 40 kHz, of a detent whose period no number of steps meets: RMS and lines."""
    detents = [{"period_deg": 2.618034, "amplitude": 0.004}, {"period_deg": 1.8, "amplitude": 0.0231}]
    bench = mechanism_of(changed(paper_table(), {"housing": None, "stepper": {"detent": detents}}))
    command, rate = COMMANDS["micro"]
    flying = to_flight(bench)
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]), highest_hz=500.0)
    state = steady_state(flying, mode, rate, (), enough_substeps(flying, mode))
    assert state.periods == 0
    torque = simulated(bench, command, 62.0, 40_000.0)[80_000:-1]
    assert state.rms == pytest.approx(np.std(torque), abs=4.0 * state.rms_error + 1e-3 * state.rms)
    assert 0.0 < state.rms_error < 0.2 * state.rms
    assert 0.01 < state.unsteady < 1.0
    lines = np.abs(2.0 / torque.size * np.fft.rfft(torque))[np.round(state.frequency_hz * 60.0).astype(int)]
    loud = np.abs(state.lines) > 0.1 * np.abs(state.lines).max()
    assert np.all(np.abs(np.abs(state.lines) - lines)[loud] < 5.0 * state.error[loud] + 1e-3 * lines[loud])
