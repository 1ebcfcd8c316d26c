"""Coupling of mechanism and structure. Truth: closed forms of the driving point, and the joined simulation."""

import numpy as np
import pytest

from mechid.budgets.coupling import dynamic_stiffness, largest_loop_gain, loop_gain
from mechid.budgets.flying_mechanism import on_modes
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.structure import FrequencyResponse, Modes, Structure

MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(37.3))
MODE = OperatingMode(name="scan", command=MICRO, rates=np.array([37.3]), settle_s=1.0, highest_hz=300.0)
SUBSTEPS = 4


@pytest.mark.parametrize("stuck", [True, False])
def test_dynamic_stiffness(flying, stuck):
    """Truth: slow, all turns with the base as one inertia; stuck, it peaks where load and gear swing."""
    v = flying.mechanism.value
    w = 2.0 * np.pi * 0.01
    row = 0 if stuck else -1
    slow = dynamic_stiffness(flying.mechanism, np.array([0.01]))[row, 0]
    assert slow.real == pytest.approx(w**2 * (v("stepper.rotor_inertia") + v("load.inertia")), rel=1e-3)
    if stuck:
        f = np.linspace(20.0, 80.0, 6001)
        peak = f[np.abs(dynamic_stiffness(flying.mechanism, f)[row]).argmax()]
        assert peak == pytest.approx(np.sqrt(v("gear.stiffness") / v("load.inertia")) / (2.0 * np.pi), rel=0.02)


def test_where_the_driving_point_is_not_known_there_is_no_criterion(flying):
    """Truth: a response without the interface. Unknown is not small."""
    f = np.array([1.0, 100.0])
    unknown = FrequencyResponse(f, np.column_stack([np.full(2, np.nan), np.ones(2)]).astype(complex))
    structure = Structure(name="s", line_of_sight=("x",), model=unknown)
    assert np.isnan(largest_loop_gain(structure, flying.mechanism, np.array([20.0, 40.0])))


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "gain"), [(0.5, 0.06), (1.5, 0.5)])
def test_the_criterion_foretells_the_two_way_torque(flying, state, shape, gain):
    """Truth: the joined simulation. T = T_held + K R T, K linearised: the largest line changes by 1/(1 - R K)."""
    modes = Modes(np.array([35.0]), np.array([0.02]), np.array([shape]), np.array([[0.05]]))
    structure = Structure(name="s", line_of_sight=("x",), model=modes)
    joined = steady_state(on_modes(flying.mechanism, modes), MODE, 37.3, (), SUBSTEPS)
    at = np.abs(state.lines).argmax()
    f = state.frequency_hz[[at]]
    RK = structure.to_interface(f)[0] * dynamic_stiffness(flying.mechanism, f)[-1, 0]
    assert loop_gain(structure, flying.mechanism, f)[0] == pytest.approx(gain, rel=0.15)
    assert abs(joined.lines[at] / state.lines[at] - 1.0 / (1.0 - RK)) < 0.01
