"""The map over one period of the steps. Truth: differences of simulations, and the exponential of a matrix."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import multipliers
from mechid.budgets.period_map import PeriodMap
from mechid.command import Command, RateProfile
from mechid.command.phase_table import nominal_table

FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(1.0), start_angle_deg=45.0)
MICRO = replace(FULL, stepping="micro", microsteps=16, start_angle_deg=0.0)
SUBSTEPS = 4


def mode(command, *rates, settle_s=1.0):
    return OperatingMode(name="m", command=command, rates=np.array(rates), settle_s=settle_s)


def period_map(flying, command, rate, names=(), **values):
    mechanism = flying.mechanism.with_values({name.replace("__", "."): value for name, value in values.items()})
    return PeriodMap(mechanism, mode(command, rate), rate, tuple(names), SUBSTEPS)


@pytest.mark.parametrize(("command", "rate"), [(FULL, 12.0), (FULL, 37.3), (FULL, 92.0), (MICRO, 23.0), (MICRO, 92.0)])
def test_the_maps_derivative_is_that_of_differences(flying, command, rate):
    """Truth: central differences of simulations of one period, across the switches on the way."""
    period = period_map(flying, command, rate)
    x = period.state_after(None, 30)
    image = period(x)
    step = 1e-6 * image.size
    for k in np.flatnonzero(period.pinned_states(x) == 0.0):
        moved = np.eye(x.size)[k] * step
        expected = (period.state_after(x + moved, 1) - period.state_after(x - moved, 1)) / (2.0 * step[k])
        np.testing.assert_allclose(
            image.by_state[:, k] * image.size[k] / image.size, expected * image.size[k] / image.size, atol=2e-5
        )


def test_a_table_of_unequal_half_periods_repeats_after_an_electrical_period(flying):
    """Truth: the settled motion of a simulation, which comes back to itself; the cosine's does after two steps."""
    table = np.where(np.arange(16)[:, None] < 8, 0.9, 1.0) * np.array(nominal_table(4))
    shaped = Command(stepping="micro", microsteps=4, rate=RateProfile.constant(1.0), table=tuple(map(tuple, table)))
    assert period_map(flying, replace(shaped, table=()), 46.0).steps == 2
    period = period_map(flying, shaped, 46.0)
    assert period.steps == 4
    x = period.state_after(None, 150)
    np.testing.assert_allclose(period.state_after(x, 1), x, atol=1e-4 * np.abs(x).max())


def test_a_linear_mechanism_in_closed_form(flying):
    """Truth: expm(A 2/r) of coils that do not act, and of rotor, gear and load without dry friction and detents."""
    v = flying.mechanism.value
    linear = {
        "stepper__torque_constant": 0.0,
        "stepper__detent__0__amplitude": 0.0,
        "stepper__detent__1__amplitude": 0.0,
        "friction__static": 0.0,
        "friction__coulomb": 0.0,
    }
    period = period_map(flying, FULL, 40.0, **linear)
    G, K, D, J, J_m = (
        v(n) for n in ("gear.ratio", "gear.stiffness", "gear.damping", "stepper.rotor_inertia", "load.inertia")
    )
    A = np.zeros((6, 6))
    A[0, 0] = A[1, 1] = -v("stepper.coil_resistance") / v("stepper.coil_inductance")
    A[2, 3] = A[4, 5] = 1.0
    twist = np.array([0.0, 0.0, K, D, -G * K, -G * D]) / G**2
    A[3] = -twist / J
    A[3, 3] -= v("friction.viscous") / J
    A[5] = G * twist / J_m
    x = np.array([0.1, -0.2, 0.0, 3.0, 1e-3, 0.01])
    expected = np.diag([-1.0, -1.0, 1.0, 1.0, 1.0, 1.0]) @ expm(A * 2.0 / 40.0)
    image = period(x)
    scale = image.size / image.size[:, None]
    np.testing.assert_allclose(image.by_state * scale, expected * scale, atol=1e-6)
    np.testing.assert_allclose(
        np.abs(multipliers(image.by_state)), np.sort(np.abs(np.linalg.eigvals(expected)))[::-1], atol=1e-6
    )
