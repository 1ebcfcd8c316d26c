"""Decimal signs and digit grouping in text files. Truth: the numbers that each file was printed from."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import RecordSpec, read_record
from mechid.records.csv_numbers import Notation, may_be_grouped, notation_of, note_kinds
from mechid.records.undeclared import read_bare

SAMPLES = np.arange(400)
COUNTS = np.round(1500.0 * np.sin(SAMPLES / 7.0)).astype(int)
DECIMALS = COUNTS / 1000.0
QUARTERS = COUNTS + 0.25


def comma(text):
    return text.replace(".", ",")


POINT_TIME = [f"{k / 1000:.4f}" for k in SAMPLES]
COMMA_TIME = [comma(text) for text in POINT_TIME]
WHOLE_TIME = [str(k) for k in SAMPLES]


def grouped(values, mark=",", decimal=".", digits=0):
    """Print numbers in groups of three digits."""
    parts = [f"{value:,.{digits}f}".partition(".") for value in values]
    return [whole.replace(",", mark) + (decimal + rest if rest else "") for whole, _, rest in parts]


def indian(values):
    """Print numbers below ten million as in India: the last three digits, then groups of two."""
    texts = [f"{abs(value):09d}" for value in values]
    marked = [f"{t[:2]},{t[2:4]},{t[4:6]},{t[6:]}".lstrip("0,") or "0" for t in texts]
    return [("-" if value < 0 else "") + text for value, text in zip(values, marked, strict=True)]


def quoted(cells):
    return [f'"{cell}"' for cell in cells]


def file(folder, time, torque, separator=";", header="time_s{}torque_Nm", encoding="utf-8"):
    rows = [separator.join(row) for row in zip(time, torque, strict=True)]
    path = folder / "run.csv"
    path.write_bytes("\n".join([header.format(separator), *rows, ""]).encode(encoding))
    return path


def read(path):
    return read_record(path, RecordSpec(name="run", path=path.name))


def look(path):
    return read_bare(path)[0]


MILLISECONDS = {"header": "t [ms]{}torque_Nm"}
REFUSED = {
    "thousands by tabs": (POINT_TIME, grouped(COUNTS), {"separator": "\t"}),
    "thousands by semicolons": (POINT_TIME, grouped(COUNTS), {}),
    "points for thousands beside decimal commas": (COMMA_TIME, grouped(COUNTS, "."), {}),
    "commas for thousands beside decimal commas": (COMMA_TIME, grouped(COUNTS), {}),
    "thousands beside whole times": (WHOLE_TIME, grouped(COUNTS), MILLISECONDS),
    "a grouped time": (grouped(10 * SAMPLES), [f"{m:.4f}" for m in DECIMALS], MILLISECONDS),
    "points for thousands by commas": (WHOLE_TIME, grouped(COUNTS, "."), {"separator": ",", **MILLISECONDS}),
    "points for thousands by spaces": (WHOLE_TIME, grouped(COUNTS, "."), {"separator": " ", "header": "t[ms]{}M_Nm"}),
    "quoted thousands": (POINT_TIME, quoted(grouped(COUNTS)), {"separator": ","}),
    "decimal commas of three digits beside points": (POINT_TIME, [comma(f"{5 + m:.3f}") for m in DECIMALS], {}),
    "decimal commas of three digits alone": (WHOLE_TIME, [comma(f"{5 + m:.3f}") for m in DECIMALS], MILLISECONDS),
    "two set points of points": (WHOLE_TIME, ["0" if k < 50 else "1.125" for k in SAMPLES], MILLISECONDS),
    "two set points": (POINT_TIME, ["0" if k < 50 else "1,000" for k in SAMPLES], {}),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("reader", [read, look])
def test_numbers_that_may_be_thousands_or_decimals_are_refused(reader, name, tmp_path):
    time, torque, how = REFUSED[name]
    with pytest.raises(RecordError, match=r"may be .* with digits grouped by thousands, or .* with a decimal"):
        reader(file(tmp_path, time, torque, **how))


def test_the_refusal_says_where_and_what_to_do(tmp_path):
    with pytest.raises(RecordError) as caught:
        read(file(tmp_path, POINT_TIME, grouped(COUNTS)))
    assert str(caught.value) == (
        'run.csv: column "torque_Nm": line 8: "1,134" may be 1134 with digits grouped by thousands, or 1.134 with a '
        'decimal comma; line 2 has "0.0000"; export the numbers without digit grouping and with one decimal sign'
    )


SIGNS = {"apostrophe": "'", "quotation mark": "’", "no-break space": "\u00a0", "thin space": "\u2009", "space": " "}
READ = {
    **{f"{name}, {separator!r}": (POINT_TIME, grouped(COUNTS, sign), COUNTS, {"separator": separator})
       for name, sign in SIGNS.items() for separator in ";\t,"},
    **{f"{name}, decimal comma": (COMMA_TIME, grouped(QUARTERS, sign, ",", 2), QUARTERS, {})
       for name, sign in SIGNS.items()},
    "no-break space in Latin-1": (POINT_TIME, grouped(COUNTS, "\u00a0"), COUNTS, {"encoding": "latin-1"}),
    "quotation mark of Windows": (POINT_TIME, grouped(COUNTS, "’"), COUNTS, {"encoding": "cp1252"}),
    "narrow no-break space in UTF-16": (POINT_TIME, grouped(COUNTS, "\u202f"), COUNTS, {"encoding": "utf-16"}),
    "points, then a decimal comma": (COMMA_TIME, grouped(QUARTERS, ".", ",", 2), QUARTERS, {}),
    "commas, then a decimal point": (POINT_TIME, grouped(QUARTERS, ",", ".", 3), QUARTERS, {"separator": "\t"}),
    "commas, then a decimal point, quoted": (
        POINT_TIME, quoted(grouped(QUARTERS, ",", ".", 2)), QUARTERS, {"separator": ","}),
    "commas in millions": (POINT_TIME, grouped(1000 * COUNTS), 1000 * COUNTS, {}),
    "points in millions": (COMMA_TIME, grouped(1000 * COUNTS, "."), 1000 * COUNTS, {}),
    "Indian groups": (POINT_TIME, indian(300 * COUNTS), 300 * COUNTS, {}),
    "three decimals": (COMMA_TIME, [comma(f"{m:.3f}") for m in DECIMALS], DECIMALS, {}),
    "three decimals, time with points": (POINT_TIME, [comma(f"{m:.3f}") for m in DECIMALS], DECIMALS, {}),
    "three decimals, whole times": (WHOLE_TIME, [comma(f"{m:.3f}") for m in DECIMALS], DECIMALS, MILLISECONDS),
    "three decimals above 1": (COMMA_TIME, [comma(f"{5 + m:.3f}") for m in DECIMALS], 5 + DECIMALS, {}),
    "three decimals above 1, points": (
        WHOLE_TIME, [f"{5 + m:.3f}" for m in DECIMALS], 5 + DECIMALS, {"separator": ",", **MILLISECONDS}),
    "as few decimals as can be": (COMMA_TIME, [comma(f"{c / 8:g}") for c in COUNTS], COUNTS / 8, {}),
    "as few decimals as can be, points": (POINT_TIME, [f"{c / 8:g}" for c in COUNTS], COUNTS / 8, {"separator": ","}),
    "exponents": (WHOLE_TIME, [comma(f"{m:.3E}") for m in DECIMALS], DECIMALS, MILLISECONDS),
    "whole numbers": (COMMA_TIME, [str(c) for c in COUNTS], COUNTS, {}),
    "set points": (
        COMMA_TIME, ["0" if k < 50 else "1,125" for k in SAMPLES], np.where(SAMPLES < 50, 0, 1.125), {}),
    "set points with points": (
        POINT_TIME, ["0" if k < 50 else "1.125" for k in SAMPLES], np.where(SAMPLES < 50, 0, 1.125),
        {"separator": ","}),
    "set points with points, whole times": (
        WHOLE_TIME, ["0" if k < 50 else "1.125" for k in SAMPLES], np.where(SAMPLES < 50, 0, 1.125),
        {"separator": ",", **MILLISECONDS}),
    "plus signs": (COMMA_TIME, [comma(f"{m:+.3f}") for m in DECIMALS], DECIMALS, {}),
    "quoted decimal commas": (
        quoted(COMMA_TIME), quoted(comma(f"{m:.6f}") for m in DECIMALS), DECIMALS, {"separator": ","}),
    "decimal commas quoted where they are": (
        quoted(COMMA_TIME),
        [f'"{comma(f"{m:g}")}"' if m % 1 else f"{m:g}" for m in DECIMALS], DECIMALS, {"separator": ","}),
    "a date beside": (
        COMMA_TIME, [comma(f"{m:.3f}") + ";25.11.2026" for m in DECIMALS], DECIMALS,
        {"header": "time_s{}torque_Nm;date"}),
    "points above the header": (
        COMMA_TIME, [comma(f"{m:.4f}") for m in DECIMALS], DECIMALS, {"header": "Serial 1.025\ntime_s{}torque_Nm"}),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
@pytest.mark.parametrize("reader", [read, look])
def test_numbers_of_one_reading_are_read(reader, name, tmp_path):
    time, torque, truth, how = READ[name]
    record = reader(file(tmp_path, time, torque, **how))
    np.testing.assert_allclose(record.channels[0].data, truth, rtol=1e-15)
    assert record.sample_rate_hz == 1000.0


STYLES = [
    *((".", "", separator, "") for separator in ",;\t "),
    *((",", "", separator, "") for separator in ";\t"),
    *((".", ",", separator, "") for separator in ";\t"),
    *((",", ".", separator, "") for separator in ";\t"),
    (".", "'", ",", ""),
    (",", "\u00a0", ";", ""),
    *((decimal, group, ",", '"') for decimal, group in (".,", ",.", (",", ""))),
]
"""Decimal sign, mark between groups, separator, quotes."""


@pytest.mark.parametrize(("decimal", "group", "separator", "quote"), STYLES)
@pytest.mark.parametrize("form", [",.0f", ",.3f", ",.6g", ".4e"])
def test_numbers_of_any_size_and_style_are_read_as_they_were_printed_or_refused(
    decimal, group, separator, quote, form, tmp_path
):
    def printed(values, form):
        texts = [f"{value:{form}}".partition(".") for value in values]
        cells = [whole.replace(",", group) + (decimal + rest if rest else "") for whole, _, rest in texts]
        return [f"{quote}{cell}{quote}" for cell in cells]

    read_at_all = 0
    for power in (-1, 0, 2, 3, 5):
        values = 10.0**power * np.sin(np.arange(60) / 5.0)
        for unit_s, time_form in ((1e-3, ",.0f"), (1.0, ",.3f")):
            time = printed(np.arange(60) * (1e-3 / unit_s), time_form)
            header = "t [ms]{}torque_Nm" if unit_s == 1e-3 else "t [s]{}torque_Nm"
            path = file(tmp_path, time, printed(values, form), separator, header.replace(" ", ""))
            try:
                record = read(path)
            except RecordError as error:
                assert "digits grouped" in str(error) or "different ways" in str(error) or "constant" in str(error)  # noqa: PT017
                continue
            read_at_all += 1
            np.testing.assert_allclose(record.channels[0].data, [float(f"{v:{form}}".replace(",", "")) for v in values])
    assert read_at_all >= 4


def test_two_decimal_signs_in_one_column_are_refused(tmp_path):
    torque = [f"{m:.4f}" if k % 2 else comma(f"{m:.4f}") for k, m in enumerate(DECIMALS)]
    with pytest.raises(RecordError, match=r'"0,0000" in line 2 and "0\.2140" in line 3 are written in different ways'):
        read(file(tmp_path, POINT_TIME, torque))


def test_grouped_digits_that_no_other_column_explains_are_named(tmp_path):
    with pytest.raises(RecordError, match=r'line 8: column "torque_Nm": "1\.134\.000" is written with grouped digits'):
        read(file(tmp_path, WHOLE_TIME, grouped(1000 * COUNTS, "."), "\t", "t [ms]{}torque_Nm"))


def test_a_long_file_is_refused_after_its_last_block(tmp_path, monkeypatch):
    monkeypatch.setattr("mechid.records.csv.WHOLE_BYTES", 100)
    monkeypatch.setattr("mechid.records.csv.AT_ONCE", 64)
    with pytest.raises(RecordError, match="may be 1134 with digits grouped"):
        read(file(tmp_path, WHOLE_TIME, grouped(COUNTS, "."), "\t", "t [ms]{}torque_Nm"))
    record = read(file(tmp_path, quoted(COMMA_TIME), quoted(comma(f"{m:.6f}") for m in DECIMALS), ","))
    np.testing.assert_allclose(record.channels[0].data, DECIMALS, rtol=1e-15)


def test_a_cell_that_is_no_number_is_told_with_its_line(tmp_path):
    torque = quoted(comma(f"{m:.6f}") for m in DECIMALS)
    torque[5] = '"1,2,3"'
    with pytest.raises(RecordError, match='line 7: column "torque_Nm": "1,2,3" is not a number'):
        read(file(tmp_path, quoted(COMMA_TIME), torque, ","))


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["1,025", "1025"], Notation(",")),
        (["1,025", "0,5"], Notation(",")),
        (["1,025.5", "996"], Notation(".", ",")),
        (["1'025", "3,5"], Notation(",", "sign")),
        (["12", "nan", ""], Notation()),
    ],
)
def test_the_notation_of_a_column_follows_from_its_cells(cells, expected):
    examples = ({},)
    for number, cell in enumerate(cells, 1):
        note_kinds(examples, number, [cell])
    assert notation_of(examples, 0, ";") == expected


def test_values_that_cannot_be_misread_thousands_are_told_without_their_cells():
    assert may_be_grouped(np.array([5.0, 996.0, 1.025]), whole=False)
    assert not may_be_grouped(np.array([5.0, 996.0]), whole=False)
    for decimal in (0.5, 1.0255, 1025.0):
        assert not may_be_grouped(np.array([5.0, 996.0, 1.025, decimal]), whole=True)
