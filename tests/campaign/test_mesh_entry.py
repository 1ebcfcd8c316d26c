"""Tooth meshes in a mechanism file. Truth: the file's own numbers, and messages written down here."""

import tomllib

import pytest

from layouts import LAYOUTS, mechanism_of, paper_with
from mechid.campaign.mechanism_text import mechanism_text

TEETH = "the teeth of the driving and of the driven wheel"
REFUSED = {
    "half a tooth": (
        [{"teeth": [74.5, 69]}],
        "teeth[0]: found 74.5; a number of teeth is a whole number from 1 to 100000",
    ),
    "no tooth": ([{"teeth": [74, 0]}], "teeth[1]: found 0; a number of teeth is a whole number from 1 to 100000"),
    "teeth in words": ([{"teeth": ["many", 69]}], 'teeth[0]: found "many"; a number of teeth is a whole number'),
    "one wheel": ([{"teeth": [74]}], f"teeth: found [74]; write teeth = [69, 74], {TEETH}"),
    "a number": ([{"teeth": 74}], f"teeth: found 74; write teeth = [69, 74], {TEETH}"),
    "no wheel": ([{}], f"teeth: missing; write teeth = [69, 74], {TEETH}"),
    "unknown key": ([{"teeth": [74, 69], "rato_behind": 2}], 'rato_behind: unknown key; did you mean "ratio_behind"?'),
    "ratio of nothing": ([{"teeth": [74, 69], "ratio_behind": 0}], "ratio_behind: found 0; ratio of the stage"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_teeth_are_one_clear_line(case, refused):
    mesh, message = REFUSED[case]
    refused(f"mechanism.toml: gear.mesh.0.{message}", paper_with, {"gear": {"mesh": mesh}})


def test_one_mesh_needs_two_brackets(refused):
    message = (
        "mechanism.toml: gear.mesh: found a table; write each mesh as a table under [[gear.mesh]], in two brackets"
    )
    refused(message, paper_with, {"gear": {"mesh": {"teeth": [74, 69]}}})


def test_an_order_may_be_the_name_of_a_line():
    """Truth: the second mesh has 75 teeth on a wheel that turns 74/69 times a rotor turn."""
    m = paper_with(LAYOUTS["tooth mesh"])
    assert m.value("gear.kinematic_error.1.order") == pytest.approx(75 * 74 / 69, rel=1e-15)
    assert m.plant.layout.orders["gear.kinematic_error"] == (74, None, 2), "a whole order shapes the equations"


def test_a_name_that_no_line_has_is_refused(refused):
    gear = {**LAYOUTS["tooth mesh"]["gear"], "kinematic_error": [{"order": "mesh 3", "amplitude": 1e-5}]}
    refused(
        'mechanism.toml: gear.kinematic_error.0.order: found "mesh 3"; did you mean "mesh 2"?',
        paper_with,
        {"gear": gear},
    )
    alone = {"gear": {"kinematic_error": [{"order": "mesh 1", "amplitude": 1e-5}]}}
    refused(
        'mechanism.toml: gear.kinematic_error.0.order: found "mesh 1", and the file has no [[gear.mesh]]',
        paper_with,
        alone,
    )


def test_a_mechanism_with_meshes_reads_back_to_equal_values():
    m = paper_with(LAYOUTS["tooth mesh"])
    text = mechanism_text(m)
    assert "teeth = [74, 69]" in text
    again = mechanism_of(tomllib.loads(text))
    assert again.plant.digest == m.plant.digest
    assert {name: again.value(name) for name in again.parameters} == {name: m.value(name) for name in m.parameters}


def test_a_train_that_is_not_the_ratio_is_refused(refused):
    """Truth: 69/74 is 0.932; a whole gear of 184 lacks a stage of 197.33."""
    message = (
        "mechanism.toml: gear.mesh: the meshes and the stages between them give a ratio of 0.932432432, gear.ratio is "
        "184; correct the teeth, or write the stage that is missing as ratio_behind = 197.333333"
    )
    refused(message, paper_with, {"gear": {"ratio": 184, "mesh": [{"teeth": [74, 69]}]}})
