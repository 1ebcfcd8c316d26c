"""``mechid design --diagnosis``: what is refused, and what is said where there is nothing to tell apart."""

import json
import shutil

import pytest

from mechid.design.diagnosis_file import DATA_NAME, FORMAT, PROPOSED_NAME, read_diagnosis
from mechid.report import diagnosis as written

ENTRY = {
    "name": "stepper.detent:7.2deg",
    "words": "detent torque with a period of 7.2 deg of the rotor",
    "parameters": {"stepper.detent.2.amplitude": {"value": 1e-3, "std_error": 1e-5, "unit": "N m"}},
    "aliases": ["stepper.phase_offset"],
}


def diagnosed(folder, *missing, **changes):
    """Write a diagnosis by hand and return its folder."""
    folder.mkdir()
    data = {"format": FORMAT, "missing": list(missing), "over_noise": {"as_written": 1.3, "with_effects": 1.0}}
    (folder / DATA_NAME).write_text(json.dumps({**data, **changes}), encoding="utf-8")
    return folder


def test_what_is_read_is_what_diagnose_writes(bench, tmp_path):
    """Truth: the names and the format of the writer; an entry with aliases is a group."""
    assert (DATA_NAME, PROPOSED_NAME, FORMAT) == (written.DATA_NAME, written.PROPOSED_NAME, written.FORMAT)
    folder = diagnosed(tmp_path / "d", ENTRY, {**ENTRY, "name": "gear.backlash", "aliases": []})
    shutil.copy(bench / "mechanism.toml", folder / PROPOSED_NAME)
    found = read_diagnosis(folder)
    assert [effect.name for effect in found.groups] == ["stepper.detent:7.2deg"]
    assert found.groups[0].aliases == ("stepper.phase_offset",)
    assert found.mechanism is not None


@pytest.mark.parametrize(
    ("missing", "changes", "message"),
    [
        ((ENTRY,), {}, "mechanism_proposed.toml"),
        ((ENTRY,), {"format": "mechid-estimate/1"}, 'this mechid reads "mechid-diagnosis/1"'),
        (({"name": "stepper.detent:7.2deg"},), {}, "is damaged ('parameters' is missing)"),
        ((), {"over_noise": None}, "is damaged"),
    ],
)
def test_a_damaged_diagnosis_is_one_line(refused, bench, tmp_path, missing, changes, message):
    folder = diagnosed(tmp_path / "d", *missing, **changes)
    said = refused(3, "design", bench, "--fit", tmp_path, "--diagnosis", folder, "--out", tmp_path / "out")
    assert message in said


def test_a_folder_without_a_diagnosis_is_one_line(refused, bench, tmp_path):
    said = refused(3, "design", bench, "--fit", tmp_path, "--diagnosis", tmp_path, "--out", tmp_path / "out")
    assert "give the folder that mechid diagnose has left" in said


def test_a_diagnosis_needs_its_fit(refused, bench, tmp_path):
    said = refused(2, "design", bench, "--diagnosis", tmp_path, "--out", tmp_path / "out")
    assert "give --fit DIR too" in said
