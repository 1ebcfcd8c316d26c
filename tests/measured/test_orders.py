"""Harmonics over a turn, from current or speed over the angle; truth: an independent fit, in the data's own index."""

import numpy as np
import pytest

from mechid.records import open_table
from mechid.signal import order_amplitudes

pytestmark = pytest.mark.data
COGGING = {72: 0.1768, 18: 0.0423, 12: 0.0306, 144: 0.0221}
"""Amplitude in A by periods a turn; of the independent fit, to be met within 5 %."""


def largest(y, turns, orders, count):
    """Return the orders of the largest sines, and all amplitudes by order."""
    found, _ = order_amplitudes(y[:, np.newaxis], turns, orders)
    amplitude = dict(zip(orders, np.abs(found[:, 0]).tolist(), strict=True))
    return sorted(amplitude, key=lambda order: -amplitude[order])[:count], amplitude


def test_the_harmonics_of_cogging(data_folder, figure):
    """31 666 points over one turn, the motor standing at each; all orders up to 150 are tried."""
    table = open_table(data_folder / "cogging" / "stopped_data.txt", "stopped_data.txt")
    names = [column.name for column in table.columns]
    position, current = table.read([names.index("Position"), names.index("Iq")])
    four, amplitude = largest(current, position / (2.0 * np.pi), range(1, 151), 4)
    assert four == list(COGGING)
    for order, expected in COGGING.items():
        figure(f"cogging: {order} a turn", amplitude[order], least=0.95 * expected, most=1.05 * expected, unit="A")


def test_the_sixth_order_of_a_servos_speed(data_folder, figure):
    """60 turns a minute before the ripple is compensated: the largest line is order 6, 5.98 Hz in the index."""
    path = next((data_folder / "torque_ripple" / "PI-QLR-SDM251").glob("*.dcexp"))
    time, speed = open_table(path, path.name).read([0, 1])
    part = slice(2000, 14000)
    turns = np.cumsum(speed / 60.0) * (time[1] - time[0])
    (order,), _ = largest(speed[part], turns[part], range(1, 40), 1)
    assert order == 6
    figure(
        "torque ripple: largest order, at its speed",
        6.0 * np.mean(speed[part]) / 60.0,
        least=5.95,
        most=6.05,
        unit="Hz",
    )
