"""The tables of a mechanism file. Truth: the files of the block library, and which of them fly."""

import pytest

from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.plant.flight import to_flight
from mechid.plant.tables import CHOICES, LISTS, OF_RECORD, OPTIONAL, TABLES, bench_reason, table_of


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("stepper.detent.12.amplitude", "stepper.detent"),
        ("gear.stiffness", "gear"),
        ("load.mode.0.frequency", "load.mode"),
        ("record.slow.time_offset_s", "record.slow"),
    ],
)
def test_the_place_in_a_list_is_no_part_of_a_table(name, table):
    assert table_of(name) == table


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_parameter_of_the_library_stands_in_a_table(variant):
    """Truth: the mechanisms that together have every law, list and optional table."""
    assert {table_of(name) for name in mechanism_of(VARIANTS[variant]).plant.declarations} <= TABLES.keys()


def test_what_stays_on_the_bench_does_not_fly():
    """Truth: the mechanism laid out for flight."""
    mechanism = mechanism_of(VARIANTS["paper"])
    flying = to_flight(mechanism).plant.declarations
    for name in mechanism.plant.declarations:
        assert bool(bench_reason(name)) == (name not in flying), name
    assert bench_reason("nothing.like_that") == ""


def test_the_views_of_the_tables_are_of_the_tables():
    assert all(TABLES[name].entry for name in LISTS)
    assert all(TABLES[name].bench for name in OF_RECORD)
    assert all(TABLES[name].optional for name in OPTIONAL)
    assert all(len(set(choices)) == len(list(choices)) >= 2 for choices in CHOICES.values())
