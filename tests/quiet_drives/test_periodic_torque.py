"""Lines at one rate. Truth: the budget's lines, which alias nothing, and differences of whole steady states."""

import numpy as np
import pytest

from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import steady_state
from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.periodic_torque import PeriodicTorque
from mechid.quiet_drives.table_basis import table_harmonics
from mechid.quiet_drives.table_command import table_command

RATE = 30.0


def test_the_lines_are_those_of_the_budget(mechanism):
    command = table_command(nominal_table(4), RATE)
    mode = OperatingMode(name="m", command=command, rates=np.array([RATE]), highest_hz=200.0)
    wanted = steady_state(mechanism, mode, RATE, (), 1)
    lines = PeriodicTorque(mechanism, RATE).lines(nominal_table(4))
    for order in (0.5, 1.0, 1.5, 2.0, 3.0):
        k = int(np.flatnonzero(np.isclose(wanted.step_orders, order))[0])
        assert abs(lines.values[lines.at(order)]) == pytest.approx(abs(wanted.lines[k]), rel=0.01, abs=1e-6)


def test_the_slopes_are_the_differences_of_steady_lines(mechanism):
    base, changes = nominal_table(4), table_harmonics(4, 5, mirrored=True)[[0, 3, 9]]
    found = PeriodicTorque(mechanism, RATE).lines_and_slopes(base, changes)
    for k, change in enumerate(changes):
        up, down = (PeriodicTorque(mechanism, RATE).lines(base + sign * 1e-4 * change) for sign in (1.0, -1.0))
        wanted = (up.values - down.values) / 2e-4
        assert np.abs(found.slopes[:, k] - wanted).max() < 2e-3 * np.abs(wanted).max()


def test_a_rate_that_the_rotor_does_not_follow_has_no_lines(mechanism):
    assert PeriodicTorque(mechanism, 5000.0).lines(nominal_table(1)) is None


def test_an_order_without_a_line_has_no_position(mechanism):
    assert PeriodicTorque(mechanism, RATE).lines(nominal_table(4)).at(0.3) is None
