"""``mechid design --diagnosis``. Truth: the diagnosis written by hand, and exit code 3 with one line."""

import json
import shutil

import pytest

from mechid.designs.diagnosis_file import read_diagnosed
from mechid.identification.result.diagnosis_file import FILE_NAME, FORMAT, PROPOSED_NAME

ENTRY = {
    "name": "stepper.detent:7.2deg",
    "words": "detent torque with a period of 7.2 deg of the rotor",
    "parameters": {"stepper.detent.2.amplitude": {"value": 1e-3, "std_error": 1e-5, "unit": "N m"}},
    "aliases": ["stepper.phase_offset"],
    "chi_square": 900.0,
    "dof": 2,
    "share": 0.9,
    "p_value": 0.0,
    "records": ["full_46"],
    "toml": "",
    "block": "stepper.detent",
}


def diagnosed(folder, *missing, **changes):
    """Write a diagnosis by hand and return its folder."""
    folder.mkdir()
    data = {
        "format": FORMAT,
        "missing": list(missing),
        "tried": [],
        "unexplained": {"share": 0.0, "words": "None."},
        "over_noise": {"as_written": 1.3, "with_effects": 1.0},
    }
    (folder / FILE_NAME).write_text(json.dumps({**data, **changes}), encoding="utf-8")
    return folder


def test_an_entry_with_aliases_is_a_group_and_hum_is_none(bench, tmp_path):
    others = ({**ENTRY, "name": name, "aliases": []} for name in ("gear.backlash", "mains:50Hz"))
    folder = diagnosed(tmp_path / "d", ENTRY, *others)
    shutil.copy(bench / "mechanism.toml", folder / PROPOSED_NAME)
    found = read_diagnosed(folder)
    assert [effect.name for effect in found.effects] == [ENTRY["name"], "gear.backlash"]
    assert [effect.name for effect in found.groups] == ["stepper.detent:7.2deg"]
    assert found.groups[0].aliases == ("stepper.phase_offset",)
    assert found.mechanism is not None


@pytest.mark.parametrize(
    ("missing", "changes", "message"),
    [
        ((ENTRY,), {}, "mechanism_proposed.toml"),
        ((ENTRY,), {"format": "mechid-estimate/1"}, 'this mechid reads "mechid-diagnosis/1"'),
        (({"name": "stepper.detent:7.2deg"},), {}, "is damaged at 'records'"),
        ((), {"over_noise": None}, "is damaged"),
    ],
)
def test_a_damaged_diagnosis_is_one_line(refused, bench, tmp_path, missing, changes, message):
    folder = diagnosed(tmp_path / "d", *missing, **changes)
    said = refused(3, "design", bench, "--fit", tmp_path, "--diagnosis", folder, "--out", tmp_path / "out")
    assert message in said


def test_a_folder_without_a_diagnosis_is_one_line(refused, bench, tmp_path):
    said = refused(3, "design", bench, "--fit", tmp_path, "--diagnosis", tmp_path, "--out", tmp_path / "out")
    assert 'there is no such file; "mechid diagnose" writes it' in said


def test_a_diagnosis_needs_its_fit(refused, bench, tmp_path):
    said = refused(2, "design", bench, "--diagnosis", tmp_path, "--out", tmp_path / "out")
    assert "give --fit DIR too" in said
