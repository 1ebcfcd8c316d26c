"""Units above and below the names of columns. Truth: torque and time in SI before they were printed in other units."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.records.csv_units import bare_unit, is_line_of_units, stated_units
from mechid.records.formats import open_table
from mechid.records.undeclared import read_bare

TIME = np.arange(40) / 2000.0
TORQUE = np.sin(np.arange(40.0))


def file(folder, head, separator=",", more=""):
    """Times in ms and torques in mN m below some lines."""
    path = folder / "run.csv"
    rows = [f"{1e3 * t:.4f}{separator}{1e3 * m:.9f}{more}" for t, m in zip(TIME, TORQUE, strict=True)]
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return path


def read(path, **asked):
    return read_record(path, RecordSpec(name="run", path=path.name, **asked))


STATED = {
    "sentence": ("# torque in mNm, time in ms\ntime,torque", ","),
    "sentence in German": ("# Drehmoment in mNm, Zeit in ms\nZeit;Drehmoment", ";"),
    "sentence in another language than the header": ("# Drehmoment in mNm, Zeit in ms\ntime,torque", ","),
    "sentence with more words": ("Time is given in ms. Torque values are in mN m.\ntime,torque", ","),
    "letters": ("# t in ms, M in mNm\nt,M", ","),
    "brackets": ("# time [ms], torque [mNm]\ntime,torque", ","),
    "parentheses": ("Time (ms) and Torque (mNm)\nTime,Torque", ","),
    "brackets without names": ("# [ms] [mNm]\ntime,torque", ","),
    "colons": ("# torque: mNm\n# time: ms\ntime,torque", ","),
    "a rate behind": ("# time in ms, torque in mNm, 10 kHz\ntime,torque", ","),
    "a date behind": ("# time in ms, torque in mNm, 2026-11-25\ntime,torque", ","),
    "units of names": ("Time unit: ms\nTorque unit: mNm\ntime,torque", ","),
    "units of names in cells": ("Time unit;ms\nEinheit Drehmoment;mNm\nTime;Drehmoment", ";"),
    "units of names in a sentence": ("# Units: torque mNm, time ms\ntime torque", " "),
    "second of an instrument": ("x-axis,1\nmilliseconds,mNm", ","),
    "equals signs": ("% torque = mNm; time = ms\ntime,torque", ","),
    "line above the names": ("ms,mNm\nTime,Torque", ","),
    "line above in brackets": ("[ms] [N mm]\ntime torque", " "),
    "line above, others between": ("ms;mNm\nraw;raw\nZeit;Mz", ";"),
    "line above with a product": ("ms,mN*m\nTime,Torque", ","),
    "line below the names": ("time torque\nms mNm", " "),
    "line below as a comment": ("time,torque\n# ms, mNm", ","),
    "sentence below": ("time,torque\n# torque in mNm, time in ms", ","),
    "label": ("Units: ms; mNm\ntime;torque", ";"),
    "label in a comment": ("# units: ms, mNm\ntime,torque", ","),
    "label in a cell": ("Einheit\tms\tmNm\nZeit\tMz", "\t"),
    "units alone": ("Recorder 7\nms,mNm", ","),
    "comment as the header": ("# run 7, bench 2\n# time [ms], torque [mNm]", ","),
    "names that say the same": ("# torque in mNm\ntime [ms],torque [mNm]", ","),
}


@pytest.mark.parametrize("name", STATED)
def test_units_that_are_stated_somewhere_are_read(name, tmp_path):
    path = file(tmp_path, *STATED[name])
    for record in (read(path), *read_bare(path)):
        assert record.sample_rate_hz == 2000.0
        np.testing.assert_allclose(record.channels[0].data, TORQUE, atol=1e-12)
        assert record.channels[0].unit == "N*m"


def test_a_line_of_units_may_hold_those_of_other_columns(tmp_path):
    for head in ("time;torque;T;x\nms;mNm;°C;-", "ms;mNm;°C;-\ntime;torque;T;x", "time;torque;T;x\nms;mNm;foo;"):
        np.testing.assert_allclose(read(file(tmp_path, head, ";", ";20;1")).channels[0].data, TORQUE, atol=1e-12)


def test_ounce_inches_above_the_names_are_the_torque_s(tmp_path):
    """Their factor to N m is of `mechid.units`."""
    table = open_table(file(tmp_path, "sec,oz-in\nTime,Torque"), "run.csv")
    assert [(column.name, column.unit) for column in table.columns] == [("Time", "sec"), ("Torque", "oz-in")]


def test_labview_states_units_of_its_channels_behind_a_label(tmp_path):
    head = "Y_Unit_Label\tmNm\t\nX_Dimension\tTime\t\n***End_of_Header***\t\nX_Value\tTorque\tComment"
    record = read(file(tmp_path, head, "\t"))
    assert record.sample_rate_hz == 2.0
    np.testing.assert_allclose(record.channels[0].data, TORQUE, atol=1e-12)


ASKED = {
    "no name": ("# all values in mNm\nt,M", 'column "M": states no unit, but line 1 says "mNm"; write its unit'),
    "no sentence": ("Transducer 5, output Ncm\nt,M", 'column "M": states no unit, but line 1 says "Ncm"'),
    "a recorder's channel": (
        "Vertical Units,V\nHorizontal Units,s\nTIME,CH1",
        'column "CH1": states no unit, but line 1 says "V"',
    ),
    "a comment as the header": ("# time in ms, torque in mNm", '"mNm" in its name may be its unit'),
    "a comment that names columns in another order": (
        "# torque in mNm, time in ms",
        'column "time in ms": states no unit, but its name says "ms"',
    ),
    "a channel's number": ("Channel 2 [mNm]\nt,M", 'column "M": states no unit, but line 1 says "mNm"'),
    "a unit alone": ("# ms\ntime,torque", 'column "time": states no unit, but line 1 says "ms"'),
    "two units": (
        "# torque in mNm\n# torque in Ncm\ntime,torque",
        'column "torque": states no unit, but line 2 says "Ncm", and another line "mNm"',
    ),
    "line and name": ("ms,mNm\ntime [ms],torque [Nm]", 'the file states two units, "mNm" and "Nm"'),
    "a unit of something else": ("s,V\ntime,torque", 'unit "V" does not measure torque'),
    "percent": ("s,%\ntime,torque", 'unknown unit "%" for torque'),
    "a unit that nobody knows": ("s,foo\ntime,torque", 'unknown unit "foo" for torque'),
}


@pytest.mark.parametrize("name", ASKED)
def test_a_unit_in_doubt_is_asked_about(name, tmp_path):
    head, words = ASKED[name]
    with pytest.raises(RecordError) as caught:
        read(file(tmp_path, head))
    assert words in str(caught.value)


def test_a_product_in_a_unit_is_no_mark_of_a_comment():
    assert bare_unit("[mN*m]") == "mN*m"
    assert bare_unit("# [m/s]") == "m/s"


def test_the_campaign_answers_what_is_asked(tmp_path):
    channels = (ChannelSpec(quantity="torque", column=1, unit="mN*m"),)
    record = read(file(tmp_path, ASKED["no name"][0]), channels=channels)
    np.testing.assert_allclose(record.channels[0].data, TORQUE, atol=1e-12)


PROSE = {
    "a range": "Range 200 mNm, serial no. 12, sampled every 0.1 ms",
    "names and places": "Bench 4, operator A. Meyer, in a hurry; test (a) of 3 in das Archiv",
    "a calibration": "Torque: calibrated 2025-11-03, ok\nTime: 10:30 h",
    "settings": "Interval (us),1000\nDuration [min]: 5\nmax torque [mNm]: 500\nsample time [ms] = 1",
    "settings of an instrument": "Filter,1 kHz\nKanal,A\nGain,mV/V",
    "a date": "Date,2025-11-26\nTime,10:00:01\nOperator,Am",
    "an oscilloscope's": "Model,7\nVertical Units,\nHorizontal Units,s\nSample Interval,1e-3",
    "units in SI": "# Units: SI\n# torque in N m, time in seconds",
    "German": "Messung in Ordnung, Drehmoment in Ordnung",
    "a unit under test": "Unit under test: A\nUnit,7",
}


@pytest.mark.parametrize("name", PROSE)
def test_prose_above_the_header_changes_nothing(name, tmp_path):
    path = file(tmp_path, f"{PROSE[name]}\ntime,torque")
    for record in (read(path), *read_bare(path)):
        assert record.sample_rate_hz == 2.0
        np.testing.assert_allclose(record.channels[0].data, 1e3 * TORQUE, atol=1e-9)


def test_a_first_column_of_another_quantity_is_no_clock(tmp_path):
    with pytest.raises(RecordError, match="no time column; give --sample-rate-hz"):
        read_bare(file(tmp_path, "angle [deg],torque [mNm]"))


def test_half_a_line_of_units_needs_a_unit_of_time():
    assert is_line_of_units(["sec", "foo"], whole=False)
    assert not is_line_of_units(["foo", "A"], whole=False)
    assert not is_line_of_units(["12", "s"], whole=False)


def test_a_unit_between_numbers_is_a_value():
    for text in ("limit 5 mNm", "torque in mNm = 500", "mNm: 12"):
        (stated,) = stated_units(["torque"], [(1, text)], str.split, 9)
        assert (stated.unit, stated.doubts) == (None, {})
