"""The tables of a fleet. Truth: the values that the fits were written with."""

import re

from mechid.fleets.tables import campaign_table, parameter_table, unit_table
from mechid.fleets.texts import fleet_texts
from printing import printed


def test_a_value_far_off_is_framed_and_tinted(data):
    """Truth: a stiffness of 0.6 of the others', so two spreads below the mean; fits of grade C say so."""
    row = next(line for line in unit_table(fleet_texts(data)).html().split("<tr>") if "gear.stiffness" in line)
    cells = re.findall(r"<td[^>]*>", row)
    assert all(part in cells[10] for part in ('class="off"', "--cold), 0.28", 'title="stands off"', "FM5  before"))
    assert 'title="grade C"' in cells[14]
    assert "background" not in cells[14]


def test_columns_that_nobody_needs_are_left_out(data):
    """Truth: units that are the campaigns, in no group."""
    bare = [{**c, "unit": c["label"], "group": None} for c in data["campaigns"]]
    labels = [column.label for column in campaign_table(fleet_texts({**data, "campaigns": bare})).columns]
    assert labels[:3] == ["campaign", "state", "temperature_degC"]


def test_a_narrow_terminal_has_mean_and_spread_below_one_another(data):
    table = parameter_table(fleet_texts(data))
    wide, narrow = (printed(lambda one, console: one.print(console), table, width) for width in (160, 80))
    assert (wide.count("parameter "), narrow.count("parameter ")) == (1, 2)
    assert "further unit" not in narrow
