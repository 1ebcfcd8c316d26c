"""Values of the mechanism file that contradict the records; truth: those that made the records."""

import re
from dataclasses import replace

import numpy as np
import pytest

from layouts import changed
from mechid.campaign import Match, mechanism_from_table
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import Reading, reinterpret_problem
from mechid.identification.readings.detectors import declaration_warnings
from mechid.identification.readings.file_values import find_wrong_counts, find_wrong_values, other_counts
from mechid.identification.readings.finding import DeclaredRecords
from mechid.identification.result.grade import Cause, Grade
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from recovery.campaigns import campaign as recovery_campaign
from recovery.mechanisms import FAMILIES, paper_table
from synthetic import COMMANDS, RATE_HZ, bench, bounded, campaign, displaced, measured, record, truth

NAMES = ("full_23", "full_46", "micro_46")


def three_records(table):
    """Return three records of the demo's mechanism, declared with another one."""
    records = [
        record(name, measured(truth(), COMMANDS[name], np.random.default_rng((7, k)), seconds=0.5), COMMANDS[name])
        for k, name in enumerate(NAMES)
    ]
    return campaign(mechanism_from_table(table, "catalogue"), *records)


def declared(made):
    """Return the records of a campaign as they are declared."""
    return DeclaredRecords(made, make_problem(made, 1))


def with_value(mechanism, name, value):
    return mechanism.with_parameters({name: replace(mechanism.parameters[name], value=value)})


def test_nothing_is_said_of_the_counts_that_made_the_records():
    assert declaration_warnings(three_records(paper_table())) == ()


@pytest.mark.parametrize("poles", [50, pytest.param(200, marks=pytest.mark.slow)])
def test_other_poles_are_named_with_the_value_that_fits(poles):
    """Truth: 100 poles; the detents' periods are those of the rotor."""
    (line,) = declaration_warnings(three_records(changed(paper_table(), {"stepper": {"poles": poles}})))
    assert f"stepper.poles = 100 ({poles} in the file)" in line
    assert "period_deg" not in line


@pytest.mark.slow
def test_poles_are_named_with_detents_that_were_declared_by_them():
    """Truth: 100 poles, detents of one and two full steps; the file has half the poles and twice the periods."""
    table = changed(paper_table(), {"stepper": {"poles": 50}})
    for detent in table["stepper"]["detent"]:
        detent["period_deg"] *= 2.0
    (line,) = declaration_warnings(three_records(table))
    assert "stepper.poles = 100" in line
    assert "stepper.detent.0.period_deg = 1.8 (3.6 in the file)" in line


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [48.0, 25.0, 62.0])
def test_another_gear_ratio_is_named_with_the_value_that_fits(ratio):
    """Truth: a ratio of 50."""
    family = FAMILIES[1]
    made = recovery_campaign(with_value(family.catalogue(), "gear.ratio", ratio), family.truth(100), 100, "all")
    found = {name: value for one in other_counts(declared(made)) for name, value in one.found.items()}
    assert found["gear.ratio"] == pytest.approx(50.0, rel=0.02)


@pytest.mark.slow
def test_an_inertia_that_would_do_as_well_is_named_beside_the_ratio():
    """Truth: neither is told from the other by these records: with 40 for 50 both explain them."""
    made = three_records(changed(paper_table(), {"gear": {"ratio": 40.0}}))
    (line,) = (finding.line() for finding in find_wrong_counts(declared(made)))
    assert float(re.search(r"gear.ratio = ([\d.]+)", line)[1]) == pytest.approx(50.0, rel=0.1)
    assert "load.inertia = 0.00" in line


@pytest.mark.slow
def test_nothing_is_said_where_no_count_explains_the_records():
    """Truth: a model without the housing, whose misfit no count makes up for."""
    table = paper_table()
    del table["housing"]
    assert list(find_wrong_counts(declared(three_records(table)))) == []


@pytest.mark.slow
def test_a_value_next_to_that_of_the_file_is_no_other_count():
    """Truth: a ratio of 50, as in the file; the search found a start at 50.02 and none at 50."""
    family = FAMILIES[1]
    made = recovery_campaign(family.catalogue(), family.truth(106), 106, "all")
    assert list(find_wrong_counts(declared(made))) == []


FREE = {"gear.stiffness": 1.05, "gear.damping": 0.6, "stepper.torque_constant": 0.9}


VALUE_NAMES = ("full_46", "full_23", "micro_46")


def file_with(changes=None, **bounds):
    """Return a mechanism file: known values of the truth, some changed, and bounds of the stiffness."""
    start = displaced(truth(), FREE).with_values(changes or {})
    return bounded(start, "gear.stiffness", **bounds) if bounds else start


def made_with(start):
    return bench(start, truth(), *VALUE_NAMES, seed=21, seconds=0.15)


WRONG = {
    "g m2 for kg m2": ("load.inertia", {"changes": {"load.inertia": 10.534}}),
    "kg cm2 the wrong way": ("stepper.rotor_inertia", {"changes": {"stepper.rotor_inertia": 8.9e-4}}),
    "bounds above": ("gear.stiffness", {"min": 1.5e3, "max": 5e3}),
    "bounds below": ("gear.stiffness", {"min": 3.0, "max": 5e1}),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ["kg cm2 the wrong way", pytest.param("bounds above", marks=pytest.mark.slow)])
def test_the_value_in_the_way_is_found(case):
    """Truth: which value was written wrongly, and the right one within a tenth."""
    name, how = WRONG[case]
    (found,) = find_wrong_values(make_problem(made_with(file_with(**how)), 1), 0, lambda name: None)
    assert (found.parameter, found.is_confirmed) == (name, True)
    value = float(found.text.partition(f"{name} at about ")[2].split()[0])
    assert value == pytest.approx(truth().value(name), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("case", WRONG)
def test_the_value_in_the_way_is_named_and_not_changed(case):
    """Truth: which value was written wrongly, and the right one within a tenth."""
    name, how = WRONG[case]
    start = file_with(**how)
    fit = identify(made_with(start), workers=1)
    assert fit.grade is Grade.C
    (said,) = (reason for reason in fit.reasons if reason.cause is Cause.VALUE_CONTRADICTED)
    assert said is fit.reasons[0]
    assert said.parameter == name
    found = float(said.text.partition(f"{name} at about ")[2].split()[0])
    assert found == pytest.approx(truth().value(name), rel=0.1)
    assert said.next_command.endswith(f"with the right unit, value or bounds of {name} in the mechanism file")
    parameter = fit.parameters[name]
    assert parameter.value == start.value(name) or parameter.min <= parameter.value <= parameter.max


def test_a_right_file_is_not_looked_at(monkeypatch):
    """Truth: records made as declared; the look is not even begun."""

    def refused(*_, **__):
        raise AssertionError("a start explains the first moments")

    monkeypatch.setattr("mechid.identification.stages.reading_rungs.find_wrong_values", refused)
    assert identify(made_with(file_with()), workers=1).grade is Grade.A


@pytest.mark.slow
def test_a_record_of_the_other_sign_is_no_wrong_value():
    """Truth: the file is right, and one record has the other polarity; no value makes up for that."""
    problem = make_problem(made_with(file_with()), 1)
    odd = reinterpret_problem(problem, {"full_23": Reading(polarity=-1)})
    assert find_wrong_values(odd, 0, lambda name: None) == []


@pytest.mark.slow
def test_a_value_that_is_wrong_by_less_than_catalogues_are_is_not_named():
    """Truth: 1.5 times the load's inertia; catalogues err by up to 2.5, so it is left to the fit and its grade."""
    fit = identify(made_with(file_with({"load.inertia": 1.5 * 0.010534})), workers=1)
    assert Cause.VALUE_CONTRADICTED not in {reason.cause for reason in fit.reasons}


@pytest.mark.slow
def test_other_poles_are_named_where_a_tachometer_is_measured_too():
    """Truth: 100 poles, told by torque and rotor rate alike."""
    true = truth()
    true = replace(true, plant=true.plant.with_outputs(("torque", "rotor_rate")))
    records = []
    for k, name in enumerate(NAMES):
        base = TimeBase(RATE_HZ, 5001)
        run = simulate_run(Simulator(true.plant, COMMANDS[name], base).run(true.kernel_values(), substeps=4))
        rng = np.random.default_rng((8, k))
        made = record(name, run.values["torque"] + 2e-3 * rng.standard_normal(base.samples), COMMANDS[name])
        tacho = replace(
            made.data.channels[0],
            quantity="rotor_rate",
            unit="rad/s",
            column="tacho",
            data=run.values["rotor_rate"] + 0.05 * rng.standard_normal(base.samples),
        )
        both = replace(made.data, channels=(*made.data.channels, tacho))
        rate = Match(quantity="rotor_rate", offset=False, drift=False)
        records.append(replace(made, data=both, matches=(*made.matches, rate)))
    wrong = mechanism_from_table(changed(paper_table(), {"stepper": {"poles": 50}}), "catalogue")
    wrong = replace(wrong, plant=wrong.plant.with_outputs(("torque", "rotor_rate")))
    (found,) = other_counts(declared(campaign(wrong, *records)))
    assert found.found["stepper.poles"] == 100
