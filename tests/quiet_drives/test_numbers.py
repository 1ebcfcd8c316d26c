"""quiet.json. Truth: the result that it is made of."""

import json

import pytest

from mechid.quiet_drives.numbers import quiet_numbers


@pytest.fixture(scope="module")
def data(found):
    return quiet_numbers(found)


def test_the_table_and_its_codes_are_there(data, found):
    table = data["table"]
    assert (table["steps_per_period"], table["bits"], table["largest_code"]) == (32, 10, 511)
    assert [a / 511 for a, _ in table["codes"]] == pytest.approx([a for a, _ in table["values"]])
    assert table["values"] == found.table.tolist()


def test_lines_before_and_after_have_rate_order_amplitude_sigma_and_unit(data):
    for name in ("before", "after"):
        assert data[name]
        assert all({"rate", "order", "amplitude", "sigma", "unit"} <= set(one) for one in data[name])
    assert all(one["unit"] == "N*m" for one in data["after"])


def test_it_is_json_without_nan(data):
    json.loads(json.dumps(data, allow_nan=False))
