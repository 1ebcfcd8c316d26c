"""Poles and gear ratio that contradict the records. Truth: the counts of the mechanism that made them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from layouts import changed
from mechid.campaign import mechanism_from_table
from mechid.identification.contradiction.wrong_count import other_counts, wrong_count_lines
from mechid.identification.identify import make_problem
from mechid.identification.stages.first_seen import declaration_warnings
from recovery.campaigns import campaign as recovery_campaign
from recovery.mechanisms import FAMILIES, paper_table
from synthetic import COMMANDS, campaign, measured, record, truth

NAMES = ("full_23", "full_46", "micro_46")


def bench(table):
    """Return three records of the demo's mechanism, declared with another one."""
    records = [
        record(name, measured(truth(), COMMANDS[name], np.random.default_rng((7, k)), seconds=0.5), COMMANDS[name])
        for k, name in enumerate(NAMES)
    ]
    return campaign(mechanism_from_table(table, "catalogue"), *records)


def with_value(mechanism, name, value):
    return mechanism.with_parameters({name: replace(mechanism.parameters[name], value=value)})


def test_nothing_is_said_of_the_counts_that_made_the_records():
    assert declaration_warnings(bench(paper_table())) == ()


@pytest.mark.parametrize("poles", [50, 200])
def test_other_poles_are_named_with_the_value_that_fits(poles):
    """Truth: 100 poles; the detents' periods are those of the rotor."""
    (line,) = declaration_warnings(bench(changed(paper_table(), {"stepper": {"poles": poles}})))
    assert f"stepper.poles = 100 ({poles} in the file)" in line
    assert "period_deg" not in line


def test_poles_are_named_with_detents_that_were_declared_by_them():
    """Truth: 100 poles, detents of one and two full steps; the file has half the poles and twice the periods."""
    table = changed(paper_table(), {"stepper": {"poles": 50}})
    for detent in table["stepper"]["detent"]:
        detent["period_deg"] *= 2.0
    (line,) = declaration_warnings(bench(table))
    assert "stepper.poles = 100" in line
    assert "stepper.detent.0.period_deg = 1.8 (3.6 in the file)" in line


@pytest.mark.parametrize("ratio", [25.0, 48.0, 62.0])
def test_another_gear_ratio_is_named_with_the_value_that_fits(ratio):
    """Truth: a ratio of 50."""
    family = FAMILIES[1]
    made = recovery_campaign(with_value(family.catalogue(), "gear.ratio", ratio), family.truth(100), 100, "all")
    found = {name: value for one in other_counts(make_problem(made, 1)) for name, value in one.found.items()}
    assert found["gear.ratio"] == pytest.approx(50.0, rel=0.02)


def test_an_inertia_that_would_do_as_well_is_named_beside_the_ratio():
    """Truth: neither is told from the other by these records: with 40 for 50 both explain them."""
    made = bench(changed(paper_table(), {"gear": {"ratio": 40.0}}))
    (line,) = wrong_count_lines(make_problem(made, 1))
    assert float(re.search(r"gear.ratio = ([\d.]+)", line)[1]) == pytest.approx(50.0, rel=0.1)
    assert "load.inertia = 0.00" in line


def test_nothing_is_said_where_no_count_explains_the_records():
    """Truth: a model without the housing, whose misfit no count makes up for."""
    table = paper_table()
    del table["housing"]
    assert wrong_count_lines(make_problem(bench(table), 1)) == []


def test_a_value_next_to_that_of_the_file_is_no_other_count():
    """Truth: a ratio of 50, as in the file; the search found a start at 50.02 and none at 50."""
    family = FAMILIES[1]
    made = recovery_campaign(family.catalogue(), family.truth(106), 106, "all")
    assert wrong_count_lines(make_problem(made, 1)) == []
