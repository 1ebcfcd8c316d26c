"""Small files by others that were read wrongly in silence (MECHID_CASES=folder); truth: their README.txt.

Each is read right, or refused with a message that names what is doubtful. Tests beside the readers rebuild their kinds.
"""

import os
from pathlib import Path

import pytest

from mechid import load_campaign, load_structure
from mechid.errors import InputFileError, RecordError
from mechid.records.undeclared import read_bare

FOLDER = Path(os.environ.get("MECHID_CASES", "no such folder"))
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="no cases: set MECHID_CASES to their folder")
TRUTH_NM = (-0.7810, 0.7929)
"""Least and largest torque of the record from which most of the files were made."""

READ = (
    "C1_pandas_index",
    "D1_hdf5_scale_factor",
    "E1_Grad",
    "F1_units_in_text_above",
    "F3_oz_in_units_above",
    "I1_quoted_decimal_comma",
)
REFUSED = {
    "A1_thousands_tab": '"1,025" may be 1025',
    "A2_thousands_semicolon": '"1,025" may be 1025',
    "B1_tdms_two_rates": "wf_increment is 0.0001 before sample 5000 and 0.0002",
    "B2_tdms_unit_change": 'unit_string is "Nm" before sample 5000 and "mNm"',
    "C2_pandas_index_torque_only": "a row number, not the time",
    "D2_hdf5_fill_value": 'sample 5000: column "torque": nan is not a finite number',
    "E2_grad_lower": "it may be degrees or gon",
}


def torque_of(case):
    (record,) = load_campaign(FOLDER / case / "campaign.toml").records
    return record.data, record.data.channel("torque").data[:]


@pytest.mark.parametrize("case", READ)
def test_a_record_is_read_right(case):
    record, torque = torque_of(case)
    assert record.sample_rate_hz == 10000.0
    assert (torque.min(), torque.max()) == pytest.approx(TRUTH_NM, abs=2e-4)


@pytest.mark.parametrize("case", READ)
def test_look_takes_the_same_columns_as_check(case):
    file = next((FOLDER / case).glob("r.*"))
    looked = read_bare(file)
    torque = next(
        c for record in looked for c in record.channels if c.unit in ("N*m", "N m", "") and "ngle" not in c.column
    )
    assert (torque.data[:].min(), torque.data[:].max()) == pytest.approx(TRUTH_NM, abs=2e-4)


def test_german_degrees_are_degrees():
    record, _ = torque_of("E1_Grad")
    angle = next(channel for channel in record.channels if channel.quantity == "rotor_angle")
    assert angle.data[:].max() == pytest.approx(1.452, abs=1e-3)


def test_days_of_a_spreadsheet_become_seconds():
    record, torque = torque_of("G1_excel_serial")
    assert record.sample_rate_hz == 100.0
    assert (torque.min(), torque.max()) == pytest.approx(TRUTH_NM, abs=1e-2)


@pytest.mark.parametrize("case", REFUSED)
def test_a_doubtful_file_is_refused_with_the_doubt(case):
    with pytest.raises(RecordError) as caught:
        load_campaign(FOLDER / case / "campaign.toml")
    assert REFUSED[case] in str(caught.value)


@pytest.mark.parametrize(
    ("case", "file", "says"), [("H1_damping_percent", "structure.csv", "percent"), ("H3_db", "response.csv", "dB")]
)
def test_a_structure_in_other_units_is_asked_about(case, file, says):
    with pytest.raises(InputFileError, match=says):
        load_structure(FOLDER / case / file)
