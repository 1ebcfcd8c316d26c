"""How a text file of numbers is written. Truth: how it was written."""

import pytest

from mechid.errors import RecordError
from mechid.records.csv_dialect import sniff

ROWS = [(0.0, 1.25, -3.5), (0.001, 2.5, 4.75), (0.002, 0.125, 5.5)]
HEADER = ("time_s", "torque_Nm", "I")


def printed(separator, *, comma, header, preamble=()):
    def number(value):
        return f"{value:.4f}".replace(".", "," if comma else ".")

    lines = [*preamble, *([separator.join(HEADER)] if header else []), *(separator.join(map(number, r)) for r in ROWS)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("header", [True, False])
@pytest.mark.parametrize(
    ("separator", "comma"),
    [(",", False), (" ", False), (";", False), (";", True), ("\t", False), ("\t", True)],
)
def test_every_way_of_writing_is_found(tmp_path, separator, comma, header, encoding):
    path = tmp_path / "a.csv"
    preamble = ("Prüfstand 3", "") if header else ()
    path.write_bytes(printed(separator, comma=comma, header=header, preamble=preamble).encode(encoding))
    found = sniff(path, "a.csv")
    assert found.separator == (None if separator == " " else separator)
    assert found.decimal_comma == comma
    assert found.head_lines == len(preamble) + header
    lines = path.read_bytes().decode(found.encoding).splitlines()[found.head_lines :]
    assert [tuple(map(float, found.cells(line))) for line in lines] == ROWS
    assert len(found.columns) == len(HEADER)
    if header:
        assert [column.name for column in found.columns] == list(HEADER)
        assert found.preamble[0] == (1, "Prüfstand 3")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the file is empty"),
        ("time_s,torque_Nm\n", "a header, but no samples after it"),
        ("time_s,torque_Nm\n0.0,1.0,2.0\n", "2 columns in the header and 3 in the first sample"),
    ],
)
def test_a_file_without_samples_is_refused(tmp_path, text, said):
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecordError, match=r"^a[.]csv: ") as caught:
        sniff(path, "a.csv")
    assert said in str(caught.value)
