"""Values of the mechanism file that are wrong by more than catalogues are; truth: what made the records."""

import pytest

from mechid.identification.contradiction.wrong_value import wrong_values
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import Reading, problem_as_read
from mechid.identification.result.grade import Cause, Grade
from synthetic import bench, bounded, displaced, truth

FREE = {"gear.stiffness": 1.05, "gear.damping": 0.6, "stepper.torque_constant": 0.9}
NAMES = ("full_46", "full_23", "micro_46")


def declared(changes=None, **bounds):
    """Return a mechanism file: known values of the truth, some changed, and bounds of the stiffness."""
    start = displaced(truth(), FREE).with_values(changes or {})
    return bounded(start, "gear.stiffness", **bounds) if bounds else start


def made(start):
    return bench(start, truth(), *NAMES, seed=21, seconds=0.15)


WRONG = {
    "g m2 for kg m2": ("load.inertia", {"changes": {"load.inertia": 10.534}}),
    "kg cm2 the wrong way": ("stepper.rotor_inertia", {"changes": {"stepper.rotor_inertia": 8.9e-4}}),
    "bounds above": ("gear.stiffness", {"min": 1.5e3, "max": 5e3}),
    "bounds below": ("gear.stiffness", {"min": 3.0, "max": 5e1}),
}


@pytest.mark.parametrize("case", ["kg cm2 the wrong way", "bounds above"])
def test_the_value_in_the_way_is_found(case):
    """Truth: which value was written wrongly, and the right one within a tenth."""
    name, how = WRONG[case]
    (found,) = wrong_values(make_problem(made(declared(**how)), 1), 0, lambda name: None)
    assert found.parameter.name == name
    assert found.found == pytest.approx(truth().value(name), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("case", WRONG)
def test_the_value_in_the_way_is_named_and_not_changed(case):
    """Truth: which value was written wrongly, and the right one within a tenth."""
    name, how = WRONG[case]
    start = declared(**how)
    fit = identify(made(start), workers=1)
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

    monkeypatch.setattr("mechid.identification.stages.growth.wrong_values", refused)
    assert identify(made(declared()), workers=1).grade is Grade.A


def test_a_record_of_the_other_sign_is_no_wrong_value():
    """Truth: the file is right, and one record has the other polarity; no value makes up for that."""
    problem = make_problem(made(declared()), 1)
    odd = problem_as_read(problem, {"full_23": Reading(polarity=-1)})
    assert wrong_values(odd, 0, lambda name: None) == []


@pytest.mark.slow
def test_a_value_that_is_wrong_by_less_than_catalogues_are_is_not_named():
    """Truth: 1.5 times the load's inertia; catalogues err by up to 2.5, so it is left to the fit and its grade."""
    fit = identify(made(declared({"load.inertia": 1.5 * 0.010534})), workers=1)
    assert Cause.VALUE_CONTRADICTED not in {reason.cause for reason in fit.reasons}
