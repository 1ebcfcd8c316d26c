"""The text reader. Truth: the arrays and the clock that each small file was built from."""

import hashlib
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record

TIME = np.arange(20) / 1000.0
TORQUE = np.sin(np.arange(20.0))
CURRENT = np.cos(np.arange(20.0))


def text(header="time_s,torque_Nm", separator=",", end="\n", decimal=".", columns=(TIME, TORQUE)):
    """One file as text: header if there is one, then a row for every sample."""
    rows = [separator.join(repr(float(value)) for value in row) for row in zip(*columns, strict=True)]
    return end.join([*([header] if header else []), *(row.replace(".", decimal) for row in rows)]) + end


@dataclass
class File:
    """A builder's file, what the campaign says of it, and what must come of it."""

    content: bytes
    asked: dict = field(default_factory=dict)
    channels: dict = field(default_factory=lambda: {"torque": TORQUE})
    start: float = 0.0
    rate: float = 1000.0


def encoded(content, encoding="utf-8", **expected):
    return File(content.encode(encoding), **expected)


TWO = {
    "channels": (
        ChannelSpec(quantity="torque", column="Mz", gain=-1.0),
        ChannelSpec(quantity="current_phase_a", column="iA", unit="mA"),
    )
}
TWO_EXPECTED = {"torque": -TORQUE, "current_phase_a": 1e-3 * CURRENT}

FILES = {
    "comma": encoded(text()),
    "semicolon": encoded(text("time_s;torque_Nm", ";")),
    "tab": encoded(text("time_s\ttorque_Nm", "\t")),
    "space": encoded(text("time_s torque_Nm", "   ")),
    "LabVIEW's empty last column": encoded(text("X_Value\tMz\tComment", "\t")),
    "comma and space": encoded(text("time_s, torque_Nm", ", ")),
    "space with units in brackets": encoded(text("time [s]  torque [N m]", "  ")),
    "decimal comma and semicolon": encoded(text("time_s;torque_Nm", ";", decimal=",")),
    "decimal comma and tab": encoded(text("time_s\ttorque_Nm", "\t", decimal=",")),
    "decimal comma after whole numbers": encoded(
        text("t;M", ";", decimal=",", columns=(TIME, np.floor(1e3 * TIME) / 2)),
        channels={"torque": np.floor(1e3 * TIME) / 2},
    ),
    "carriage return and line feed": encoded(text(end="\r\n")),
    "carriage return": encoded(text(end="\r")),
    "no final newline": encoded(text().rstrip("\n")),
    "blank lines at the end": encoded(text() + "\n\n"),
    "blank lines before": encoded("\n\n" + text()),
    "byte order mark": encoded(text(), "utf-8-sig"),
    "byte order mark, no header": encoded(text(None), "utf-8-sig"),
    "UTF-16": encoded(text(), "utf-16"),
    "UTF-8": encoded(text("Zeit [s],Größe [N·m]")),
    "Latin-1": encoded(text("Zeit [s],Größe [N·m]"), "latin-1"),
    "no header": encoded(text(None)),
    "no header, indices": encoded(
        text(None, columns=(TIME, CURRENT, TORQUE)), asked={"channels": (ChannelSpec(quantity="torque", column=2),)}
    ),
    "units in a second line": encoded(text("time,torque\nms,mNm"), channels={"torque": 1e-3 * TORQUE}, rate=1e6),
    "units in a second line, in brackets, not all": encoded(
        text("time;torque;x\n[s];[mNm];[-]", ";", columns=(TIME, TORQUE, CURRENT)), channels={"torque": 1e-3 * TORQUE}
    ),
    "an instrument's own lines before the header": encoded(
        "Recorder 7\n\nInterval (us)\t1000\nSerial no. 12\n\n" + text("Time (s)\tTorque (mNm)", "\t"),
        channels={"torque": 1e-3 * TORQUE},
    ),
    "quoted": encoded(text('"time_s","torque, raw"').replace("0.001,", '"0.001",')),
    "no unit": encoded(text("t,M")),
    "milli": encoded(text("t/ms,M [mNm]"), channels={"torque": 1e-3 * TORQUE}, rate=1e6),
    "microseconds": encoded(text("time [µs],M (N.m)", columns=(1e6 * TIME, TORQUE))),
    "late start": encoded(text(columns=(TIME + 0.25, TORQUE)), start=0.25),
    "clock of a calendar": encoded(text(columns=(TIME + 1.7e9, TORQUE)), start=1.7e9),
    "torque alone": encoded(text("torque_Nm", columns=(TORQUE,)), asked={"sample_rate_hz": 1000.0}),
    "torque alone, no header": encoded(text(None, columns=(TORQUE,)), asked={"sample_rate_hz": 1000.0}),
    "torque first": encoded(
        text("torque_mNm,temperature", columns=(TORQUE, CURRENT)),
        asked={"sample_rate_hz": 1000.0},
        channels={"torque": 1e-3 * TORQUE},
    ),
    "channels after the time": encoded(
        text("time_s,iA,Mz [N*m]", columns=(TIME, CURRENT, TORQUE)), asked=TWO, channels=TWO_EXPECTED
    ),
    "time after the channels": encoded(
        text("Mz,iA,Time", columns=(TORQUE, CURRENT, TIME)), asked=TWO, channels=TWO_EXPECTED
    ),
    "first column is the time, whatever its name": encoded(
        text("abscissa,Mz,iA", columns=(TIME, TORQUE, CURRENT)), asked=TWO, channels=TWO_EXPECTED
    ),
    "channels without time": encoded(
        text("iA,Mz", columns=(CURRENT, TORQUE)),
        asked={"sample_rate_hz": 500.0, **TWO},
        channels=TWO_EXPECTED,
        rate=500.0,
    ),
    "channels with time and rate": encoded(
        text("t,iA,Mz", columns=(TIME + 3.0, CURRENT, TORQUE)),
        asked={"sample_rate_hz": 1000.0, **TWO},
        channels=TWO_EXPECTED,
        start=3.0,
    ),
    "a column of words that nobody wants": encoded(
        "time_s,torque_Nm,remark\n" + "".join(f"{t},{m},ok é {t}\n" for t, m in zip(TIME, TORQUE, strict=True))
    ),
    "a sparse column that nobody wants": encoded(
        "time_s,torque_Nm,temperature\n" + "".join(f"{t},{m},\n" for t, m in zip(TIME, TORQUE, strict=True))
    ),
}


def write(folder, content, name="run.csv"):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read(path, **asked):
    return read_record(path, RecordSpec(name="run", path=path.name, **asked))


@pytest.mark.parametrize("name", FILES)
def test_a_file_gives_the_arrays_and_the_clock_it_was_built_from(name, tmp_path):
    file = FILES[name]
    record = read(write(tmp_path, file.content), **file.asked)
    assert [channel.quantity for channel in record.channels] == list(file.channels)
    for quantity, expected in file.channels.items():
        data = record.channel(quantity).data
        np.testing.assert_allclose(data, expected, rtol=1e-15)
        assert data.dtype == np.float64
        assert data.flags.c_contiguous
    assert record.time_start_s == pytest.approx(file.start, abs=1e-15)
    assert record.sample_rate_hz == file.rate
    assert record.digest == hashlib.sha256(file.content).hexdigest()
    assert record.warnings == ()


def rows(*changes, header="time_s,torque_Nm\n"):
    """Twenty good rows of 1 kHz with some of them replaced: (index of the row, its text)."""
    lines = [f"{t:.6f},{m:.9f}" for t, m in zip(TIME, TORQUE, strict=True)]
    for index, line in changes:
        lines[index] = line
    return header + "\n".join(lines) + "\n"


MZ = {"channels": (ChannelSpec(quantity="torque", column="Mz"),)}

REFUSED = {
    "empty": (b"", {}, "run.csv: the file is empty"),
    "blank": (b"\n \n", {}, "run.csv: the file is empty"),
    "binary": (b"MATLAB\0\1\2\n\3", {}, "run.csv: not a text file; export it as csv"),
    "half a UTF-16 letter": (
        text().encode("utf-16") + b"1",
        {},
        "run.csv: is not valid utf-16-le text, which it claims to be",
    ),
    "header only": (b"time_s,torque_Nm\n", {}, "run.csv: line 1: a header, but no samples after it"),
    "few": ("".join(rows().splitlines(keepends=True)[:16]), {}, "run.csv: 15 samples; a record needs 16 at least"),
    "word": (rows((5, "0.005,n/a")), {}, 'run.csv: line 7: column "torque_Nm": "n/a" is not a number'),
    "python number": (rows((5, "0.005,1_0")), {}, 'run.csv: line 7: column "torque_Nm": "1_0" is not a number'),
    "minus that is no hyphen": (
        rows((5, "0.005,\u22121.5")),
        {},
        'run.csv: line 7: column "torque_Nm": "\u22121.5" is not a number in plain letters; export the file with the '
        'digits 0 to 9, ".", "-" and no other signs',
    ),
    "time of day": (
        rows((5, "2026-11-25T10:00:01.5,0.1")),
        {},
        'run.csv: line 7: column "time_s": "2026-11-25T10:00:01.5" is not a number but a time of day; export the '
        "seconds since the first sample instead",
    ),
    "word without header": (rows((5, "0.005,n/a"), header=""), {}, 'run.csv: line 6: column 1: "n/a" is not a number'),
    "word after blank lines": (
        rows((5, "\n\n0.005,n/a")),
        {},
        'run.csv: line 9: column "torque_Nm": "n/a" is not a number',
    ),
    "hole": (rows((0, "0.0,")), {}, 'run.csv: line 2: column "torque_Nm": the cell is empty'),
    "words in a second line": (
        rows(header="time,torque\nsee,log\n"),
        {"channels": (ChannelSpec(quantity="torque", column="torque"),)},
        'run.csv: torque: unknown column "torque"; the file has "see", "log"',
    ),
    "unit of another quantity in a second line": (
        rows(header="time,torque\nms,V\n"),
        {},
        'run.csv: column "torque": unit "V" does not measure torque; expected N*m or a multiple of it; '
        "if that is no unit, name the right one in channels",
    ),
    "short row": (rows((19, "0.019")), {}, "run.csv: line 21: found 1 cells, but the file has 2 columns"),
    "long row": (rows((3, "0.003,1,2")), {}, "run.csv: line 5: found 3 cells, but the file has 2 columns"),
    "two merged rows": (
        rows((3, "0.003,0.50.004,1.0")),
        {},
        "run.csv: line 5: found 3 cells, but the file has 2 columns",
    ),
    "long row in a wide file": (
        text("t,Mz,a,b", columns=(TIME, TORQUE, TIME, TIME)) + "0.02,1,2,3,4\n",
        MZ,
        "run.csv: line 22: found 5 cells, but the file has 4 columns",
    ),
    "decimal comma and comma": (
        text(decimal=","),
        {},
        "run.csv: 2 columns in the header and 4 in the first sample; "
        "a decimal comma needs semicolons or tabs between columns",
    ),
    "not a number": (
        rows((9, "0.009,nan")),
        {},
        'run.csv: line 11: column "torque_Nm": nan is not a finite number; max_gap_s = ... allows to bridge missing '
        "samples, window_s to leave them out",
    ),
    "infinite": (rows((9, "0.009,-inf")), {}, 'run.csv: line 11: column "torque_Nm": -inf is not a finite number'),
    "too large": (rows((9, "0.009,1e999")), {}, 'run.csv: line 11: column "torque_Nm": inf is not a finite number'),
    "time is not a number": (rows((9, "nan,0.0")), {}, 'run.csv: line 11: column "time_s": nan is not a finite number'),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_file_is_refused_with_its_line(name, tmp_path):
    content, asked, message = REFUSED[name]
    path = write(tmp_path, content)
    with pytest.raises(RecordError) as caught:
        read(path, **asked)
    assert str(caught.value) == message


def test_a_missing_file_is_refused_with_the_nearest_name(tmp_path):
    write(tmp_path, text(), "full_46.csv")
    with pytest.raises(RecordError) as caught:
        read(tmp_path / "ful_46.csv")
    assert str(caught.value) == 'ful_46.csv: there is no such file; did you mean "full_46.csv"?'


def test_a_missing_folder_is_refused_with_where_the_file_was_looked_for(tmp_path):
    path = tmp_path / "absent" / "run.csv"
    with pytest.raises(RecordError) as caught:
        read(path)
    assert str(caught.value) == f"run.csv: there is no such file ({path})"


def test_a_folder_is_refused(tmp_path):
    with pytest.raises(RecordError, match="is a folder, not a file"):
        read(tmp_path)


def test_an_unknown_format_is_refused_with_the_known_ones(tmp_path):
    path = write(tmp_path, text(), "run.wav")
    with pytest.raises(RecordError, match=r'run.wav: no reader for ".wav"; mechid reads .csv, .tsv, .*, .mat, .*.npz'):
        read(path)


def test_the_lines_before_the_header_are_kept(tmp_path):
    path = write(tmp_path, "Recorder 7\nSerial no. 12\n" + text())
    assert read(path).metadata == {"line 1": "Recorder 7", "line 2": "Serial no. 12"}


FIXED = "time_s,torque_Nm\n" + "".join(f"{t:.6f},{m:.9e}\n" for t, m in zip(TIME, TORQUE, strict=True))


def test_a_file_cut_within_its_last_number_is_said(tmp_path):
    """Truth: the file was whole; every cut within the last number leaves a number that is another one."""
    whole = FIXED.rstrip("\n")
    start = whole.rindex(",") + 2
    for end in range(start, len(whole)):
        try:
            record = read(write(tmp_path, whole[:end]))
        except RecordError as error:
            assert "is not a number" in str(error) or "cells where" in str(error)  # noqa: PT017
            continue
        assert record.warnings
        assert "is the file cut off there?" in record.warnings[0]
    assert read(write(tmp_path, whole)).warnings == ()


SHORTEST = "time_s,torque_Nm\n" + "".join(
    f"{t!r},{m!r}\n" for t, m in zip(TIME.tolist(), (3e-4 * TORQUE).tolist(), strict=True)
)
LAST = {"as short as can be": "1.2345678901234567e-05", "many digits": "0.12345678901234567", "a whole part": "123.5"}
COUNTS = "t_s,torque_Nm\n" + "".join(f"{t!r},{7**k % 100003}\n" for k, t in enumerate(TIME.tolist()))


@pytest.mark.parametrize("last", LAST.values(), ids=LAST)
def test_a_cut_in_a_number_of_any_length_is_said_or_does_not_matter(tmp_path, last):
    """Truth: the number before the cut; a digit in the 10th place of a torque does not matter."""
    whole = SHORTEST + f"0.02,{last}"
    for end in range(len(whole) - len(last) + 1, len(whole)):
        try:
            record = read(write(tmp_path, whole[:end]))
        except RecordError as error:
            assert "is not a number" in str(error)  # noqa: PT017
            continue
        if not record.warnings:
            assert record.channel("torque").data[-1] == pytest.approx(float(last), abs=1e-9)
    assert read(write(tmp_path, whole + "\n")).warnings == ()


def test_a_cut_in_a_whole_number_is_said(tmp_path):
    assert "is the file cut off there?" in read(write(tmp_path, COUNTS[:-2])).warnings[0]
    assert read(write(tmp_path, COUNTS)).warnings == ()


def test_the_suffix_may_be_in_capitals(tmp_path):
    assert read(write(tmp_path, text(), "RUN.CSV")).samples == 20


CELLS = st.sampled_from(["0", "0.001", "1e3", "-2,5", "nan", "x", "", '"', '"1"', " ", "1_0", "é", "\0"])
MARKS = st.sampled_from([",", ";", "\t", " ", "\n", "\r\n", "\r"])


@settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.lists(st.tuples(CELLS, MARKS), max_size=60), st.sampled_from(["utf-8", "latin-1", "utf-16"]))
def test_any_text_is_a_record_or_refused(tmp_path, cells, encoding):
    content = "".join(cell + mark for cell, mark in cells).encode(encoding)
    try:
        assert read(write(tmp_path, content)).samples >= 16
    except RecordError as error:
        assert str(error).startswith("run.csv: ")  # noqa: PT017
