"""The stages of campaign.toml; truth: the campaign contract."""

import re

import pytest

from mechid.campaign import Stage, load_campaign
from mechid.errors import InputFileError

STAGE = """
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.3]
free = ["gear.stiffness", "stepper.coil_resistance"]
"""


def with_stage(folder, old="", new=""):
    path = folder / "campaign.toml"
    assert old in STAGE
    path.write_text(path.read_text().replace('use = "validate"\n', "") + STAGE.replace(old, new, 1 if old else 0))
    return path


def test_a_stage(folder):
    stage = Stage(("full_46",), (0.0, 0.3), ("gear.stiffness", "stepper.coil_resistance"))
    assert load_campaign(with_stage(folder)).stages == (stage,)


def test_a_stage_without_window_and_records_takes_all_that_are_estimated(folder):
    path = folder / "campaign.toml"
    path.write_text(path.read_text() + '[[stage]]\nfree = ["gear.stiffness"]\n')
    assert load_campaign(path).stages == (Stage(("full_46",), None, ("gear.stiffness",)),)


def test_a_stage_may_move_a_records_own_parameter(folder):
    path = with_stage(folder, 'records = ["full_46"]', 'records = ["full_46", "sweep"]')
    path.write_text(path.read_text().replace('"gear.stiffness"', '"record.sweep.time_offset_s"'))
    assert load_campaign(path).stages[0].free[0] == "record.sweep.time_offset_s"


def test_a_stage_does_not_fit_a_record_for_validation(folder):
    path = with_stage(folder, '["full_46"]', '["sweep"]')
    path.write_text(path.read_text().replace('file = "sweep.csv"', 'file = "sweep.csv"\nuse = "validate"'))
    message = '"sweep" is for validation; take it out, or give that record use = "estimate"'
    with pytest.raises(InputFileError, match=re.escape(f"stage[0].records[0]: {message}")):
        load_campaign(path)


STAGES_REFUSED = {
    "unknown parameter": (
        '"gear.stiffness"',
        '"gear.stifness"',
        'free[0]: unknown parameter "gear.stifness"; did you mean "gear.stiffness"?',
    ),
    "strange parameter": (
        '"gear.stiffness"',
        '"q"',
        'free[0]: unknown parameter "q"; free are: stepper.coil_resistance, stepper.detent.0.amplitude, ',
    ),
    "known parameter": (
        '"gear.stiffness"',
        '"gear.damping"',
        'free[0]: "gear.damping" is known, not free; to free it, write { value = ..., ',
    ),
    "tied parameter": (
        '"gear.stiffness"',
        '"stepper.back_emf_constant"',
        'free[0]: "stepper.back_emf_constant" is tied to stepper.torque_constant; free that one, or ',
    ),
    "parameter of another record": (
        '"gear.stiffness"',
        '"record.sweep.time_offset_s"',
        'free[0]: "record.sweep.time_offset_s" belongs to a record that is not in this stage; add "sweep"',
    ),
    "parameter twice": (
        '"gear.stiffness", "stepper.coil_resistance"',
        '"gear.stiffness", "gear.stiffness"',
        'free[1]: "gear.stiffness" is listed twice; keep one',
    ),
    "nothing free": (
        '["gear.stiffness", "stepper.coil_resistance"]',
        "[]",
        'free: found []; write names of parameters to move, as free = ["gear.stiffness"]',
    ),
    "no entry for free": (
        'free = ["gear.stiffness", "stepper.coil_resistance"]',
        "",
        'free: missing; write names of parameters to move, as free = ["gear.stiffness"]',
    ),
    "unknown record": (
        '["full_46"]',
        '["full_64x"]',
        'records[0]: unknown record "full_64x"; did you mean "full_46"?',
    ),
    "strange record": (
        '["full_46"]',
        '["q"]',
        'records[0]: unknown record "q"; there are full_46, sweep',
    ),
    "record that is no text": (
        '["full_46"]',
        "[1]",
        'records[0]: found 1; write names of records, as records = ["full_46"]',
    ),
    "records of a wrong type": (
        '["full_46"]',
        '"full_46"',
        'records: found "full_46"; write names of records, as records = ["full_46"]',
    ),
    "window reversed": (
        "[0.0, 0.3]",
        "[0.3, 0.0]",
        "window_s: from 0.3 s to 0 s is no window; put the earlier time first",
    ),
    "window outside": (
        "[0.0, 0.3]",
        "[1.5, 2.0]",
        'window_s: 1.5 s to 2 s is outside; record "full_46" goes from 0 s to 1 s',
    ),
    "window of a wrong type": (
        "[0.0, 0.3]",
        "0.3",
        "window_s: found 0.3; write from and to in s of record time, as window_s = [0.0, 0.3]",
    ),
    "window of texts": (
        "[0.0, 0.3]",
        '[0.0, "0.3 s"]',
        'window_s[1]: found "0.3 s"; write the number alone in s, without quotes',
    ),
    "unknown key": ("window_s", "window", 'window: unknown key; did you mean "window_s"?'),
}


@pytest.mark.parametrize("name", STAGES_REFUSED)
def test_a_wrong_stage_says_where_what_and_the_remedy(name, folder, refused):
    old, new, message = STAGES_REFUSED[name]
    path = with_stage(folder, old, new)
    refused(f"campaign.toml: stage[0].{message}", load_campaign, path)
