"""Search for a table. Truth: lines of the found table, simulated anew, beside those of the sine."""

import pytest

from mechid.command.phase_table import nominal_table
from mechid.errors import FitError
from mechid.quiet_drives.periodic_torque import PeriodicTorque
from mechid.quiet_drives.table_search import design_places, range_places, rise_db


def test_the_chosen_orders_fall_at_the_design_rate_and_beside_it(found, mechanism):
    for rate, factor in ((30.0, 10.0), (28.5, 3.0), (32.0, 3.0)):
        before, after = (PeriodicTorque(mechanism, rate).lines(table) for table in (found.nominal, found.exact))
        for order in (1.0, 2.0):
            k = before.at(order)
            assert abs(after.values[k]) < abs(before.values[k]) / factor


def test_the_table_is_nowhere_louder_than_promised(found, mechanism):
    for place in range_places(mechanism, found.nominal, [28.0, 31.3, 33.0]):
        assert rise_db(place, found.table) < 1.0


def test_neighbours_of_a_design_rate_join_within_the_range(mechanism):
    places = design_places([mechanism], nominal_table(4), [30.0], (28.0, 34.0))
    assert sorted(p.torque.rate for p in places if p.weight) == [30.0, 33.0]


def test_a_rate_that_loses_steps_is_named(mechanism):
    with pytest.raises(FitError, match="at 5000 full steps/s the nominal table fails"):
        range_places(mechanism, nominal_table(1), [5000.0])
