"""Stiffness and damping over the depth of a notch. Truth: margins and poles of scaled loops; a spring."""

import numpy as np
import pytest

from mechid.exports.linear.loops.closing import DrivenPlant, close_position_loop, position_plant
from mechid.exports.linear.loops.loop_file import LoopDesign, Notch, PositionLoop, SampledTiming
from mechid.exports.linear.loops.margins import margins_of, unstable_pole
from mechid.exports.linear.loops.trade import (
    DEPTHS,
    holding_of,
    largest_factor,
    scale_gains,
    trade_notch,
    trade_table,
)
from mechid.exports.linear.state_space import Matrices

SPRING, INERTIA, ZETA = 900.0, 0.01, 0.05
W = np.sqrt(SPRING / INERTIA)
PHASES = ("added_current_phase_a", "added_current_phase_b")
T = 1e-3


def driven(spring=SPRING):
    """Return a mass on a spring that the currents turn by 2 N m/A, held at 90 deg: phase A alone acts."""
    A = np.array([[0.0, 1.0], [-spring / INERTIA, -2.0 * ZETA * W]])
    B = np.array([[0.0, 0.0, 0.0], [2.0 / INERTIA, 0.0, 1.0 / INERTIA]])
    matrices = Matrices(A, B, np.array([[1.0, 0.0]]), np.zeros((1, 3)))
    plant = DrivenPlant(matrices, (*PHASES, "output_torque"), ("output_angle",), np.pi / 2.0)
    return position_plant(plant, DESIGN, None)


DESIGN = LoopDesign(
    position=PositionLoop(
        sensor="output_angle", kp=45.0, ki=9000.0, kd=0.2, timing=SampledTiming(period_s=T, delay_s=T)
    )
)


def test_holding_of_a_proportional_loop_is_spring_and_gain():
    """Truth: 900 N m/rad of the spring and 2 N m/A x 45 A/rad, less inertia x w^2 at the frequency of the stiffness."""
    design = LoopDesign(
        position=PositionLoop(sensor="output_angle", kp=45.0, ki=0.0, kd=0.0, timing=DESIGN.position.timing)
    )
    loop = close_position_loop(driven(), design, None, 1.0)
    found = holding_of(loop, [close_position_loop(driven(1000.0), design, None, 1.0)], W / (2.0 * np.pi))
    assert float(found.stiffness.value) == pytest.approx(900.0 + 90.0 - INERTIA * (0.1 * W) ** 2, rel=2e-3)
    assert float(found.stiffness.high) == pytest.approx(1000.0 + 90.0 - INERTIA * (0.1 * W) ** 2, rel=2e-3)
    poles = loop.closed.poles
    s = np.log(poles[(np.abs(poles) > 0.1) & (np.abs(poles - 1.0) > 1e-9)]) / T
    assert float(found.damping.value) == pytest.approx(float((-s.real / np.abs(s)).min()), rel=1e-9)
    # The delay of a sample and the hold take damping: kp 2 N m/A x 1.5 ms against the damper.
    assert float(found.damping.value) == pytest.approx(ZETA - 0.5 * 90.0 * 1.5e-3 / (INERTIA * W), rel=0.1)
    assert float(found.least_stiffness.value) < 2.1 * float(found.damping.value) * 990.0


@pytest.mark.parametrize("depth", [None, 0.3])
def test_the_largest_factor_keeps_both_margins(depth):
    """Truth: margins of the loop with its gains multiplied, one of them at its limit."""
    notch = None if depth is None else Notch(frequency_hz=W / (2.0 * np.pi), damping=0.5, depth=depth)
    plain = close_position_loop(driven(), DESIGN, notch, 1.0)
    hertz = np.linspace(0.5, 499.5, 20_000)
    factor = largest_factor(plain.open.response(hertz)[:, 0, 0])
    scaled = LoopDesign(position=scale_gains(DESIGN.position, factor))
    loop = close_position_loop(driven(), scaled, notch, 1.0)
    found = margins_of(loop.open)
    assert unstable_pole(loop.closed) is None
    assert found.gain_dB > 6.0 - 0.02
    assert found.phase_deg > 30.0 - 0.1
    assert found.gain_dB < 6.05 or found.phase_deg < 30.5


def test_a_trade_compares_depths():
    """Truth: a notch lets the gains rise; each entry is the loop closed with its factor."""
    mode_hz = W / (2.0 * np.pi)
    notch = Notch(frequency_hz=mode_hz, damping=0.5, depth=0.1)
    choices = trade_notch(driven(), [driven(870.0), driven(930.0)], DESIGN, notch, mode_hz, 1.0)
    assert [choice.depth for choice in choices] == [*DEPTHS]
    without, shallow = choices[0], choices[DEPTHS.index(0.5)]
    assert shallow.factor > without.factor > 0.0
    assert float(shallow.holding.stiffness.value) > float(without.holding.stiffness.value)
    table = trade_table(choices)
    assert table["factor"][0] == without.factor
    assert table["damping"]["low"][0] <= table["damping"]["value"][0] <= table["damping"]["high"][0]


def test_no_factor_keeps_a_loop_of_the_wrong_sense():
    """Truth: 1 - L is unstable at any gain for which it matters; the table has null."""
    mode_hz = W / (2.0 * np.pi)
    notch = Notch(frequency_hz=mode_hz, damping=0.5, depth=0.1)
    choice = trade_notch(driven(), [], DESIGN, notch, mode_hz, -1.0)[0]
    assert (choice.factor, choice.holding) == (None, None)
    assert trade_table([choice])["stiffness"] == {"value": [None], "low": [None], "high": [None]}
