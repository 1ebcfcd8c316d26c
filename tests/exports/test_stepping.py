"""Stepping modes of a campaign. Truth: the commands, written by hand."""

from dataclasses import dataclass

import numpy as np

import mechid
from mechid.command import Command
from mechid.command.phase_table import nominal_table
from mechid.exports.stepping import steppings
from mechid.simulation.simulator import TimeBase

COSINE = nominal_table(4)
BASE = TimeBase(1000.0, 1000)
UNEQUAL = np.where(np.arange(16)[:, None] < 8, 0.9, 1.0) * COSINE


@dataclass(frozen=True)
class Run:
    command: Command
    base: TimeBase = BASE


def micro(rate, table=None, angle=0.0):
    return Run(mechid.make_command("micro", microsteps=4, rate=rate, table=table, start_angle_deg=angle))


def test_start_angles_that_give_the_same_motion_are_one_mode():
    """Truth: a microstep turns the cosine into itself, a quarter a table of equal quarters, a turn any table."""
    assert [len(s.ranges) for s in steppings([micro(10.0), micro(20.0, angle=22.5)])] == [2]
    assert [len(s.ranges) for s in steppings([micro(10.0, COSINE), micro(20.0, COSINE, 90.0)])] == [2]
    assert [len(s.ranges) for s in steppings([micro(10.0, UNEQUAL), micro(20.0, UNEQUAL, 360.0)])] == [2]
    assert len(steppings([micro(10.0, UNEQUAL), micro(20.0, UNEQUAL, 90.0)])) == 2
    assert len(steppings([micro(10.0), micro(20.0, angle=10.0)])) == 2


def test_each_mode_has_a_name_of_its_own():
    """Truth: names become file names, so that none may come twice."""
    found = steppings([micro(10.0), micro(10.0, angle=10.0), micro(10.0, 0.9 * COSINE), micro(10.0, UNEQUAL)])
    assert [s.name for s in found] == ["micro4_0deg", "micro4_10deg", "micro4_table_3", "micro4_table_4"]


def test_a_range_is_that_of_the_whole_record():
    """Truth: a ramp from 10 to 30 within the record, a reversal through 0."""
    (mode,) = steppings([micro([[0.0, 10.0], [1.0, 30.0], [9.0, 90.0]]), micro([[0.0, -5.0], [1.0, 5.0]])])
    np.testing.assert_allclose(mode.ranges, [(10.0, 30.0), (0.0, 5.0)], atol=0.1)
    assert mode.covers(np.array([3.0, 7.0, 20.0])).tolist() == [True, False, True]
