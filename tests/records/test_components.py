"""Moments moved to the mounting point: held against statics."""

import numpy as np
import pytest

from mechid.records import Mounting, move_to_mounting_point
from mechid.records.components import COMPONENTS
from table_of_six import MEASURED, measured

EXERTED = {name: {1.0: 0.1 * (k + 1) * np.exp(1j * k)} for k, name in enumerate(COMPONENTS)}


def exerted_alone(mounting):
    """Return a record without noise as a table with its reference at the mounting point would give it."""
    return measured(
        EXERTED, 10.0, np.random.default_rng(0), noise=0.0, mounting=Mounting(mounting.drive_axis, (0, 0, 0))
    )


@pytest.mark.parametrize("point", [(0.0, 0.0, 0.05), (0.02, -0.03, 0.06)])
def test_moments_are_those_that_the_mechanism_exerts(point):
    """Truth: M_O = M_P + r x F, by which the table's were made; the torque is one of them."""
    mounting = Mounting("z", point)
    there, moved = (
        exerted_alone(mounting),
        move_to_mounting_point(
            measured(EXERTED, 10.0, np.random.default_rng(0), noise=0.0, mounting=mounting), mounting
        ),
    )
    for name in ("torque", *MEASURED):
        np.testing.assert_allclose(moved.channel(name).data, there.channel(name).data, atol=1e-14)
    assert moved.treatments[-1]["step"] == "moved"
    assert ("torque" in moved.treatments[-1]["text"]) == (point[0] != 0.0)


def test_a_torque_about_the_opposite_axis():
    """Truth: the same table, its drive torque counted the other way."""
    there = measured(EXERTED, 10.0, np.random.default_rng(0), noise=0.0)
    other = Mounting("-z", (0.02, -0.03, 0.06))
    there.channel("torque").data[:] *= -1.0
    known = exerted_alone(other).channel("torque").data
    np.testing.assert_allclose(move_to_mounting_point(there, other).channel("torque").data, -known, atol=1e-14)


def test_without_a_lever_arm_nothing_is_touched():
    record = measured(EXERTED, 10.0, np.random.default_rng(0))
    assert move_to_mounting_point(record, Mounting("z", (0.0, 0.0, 0.0))) is record
