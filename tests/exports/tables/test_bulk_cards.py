"""Nastran cards of the lines: by the format's own rules, by two other readers, and by the lines they are made of."""

import csv
import math

import numpy as np
import pytest

from mechid.exports.tables.bulk_cards import darea, rload1, rload2, tabled1
from nastran_cards import cards, value

AREA, REAL, IMAGINARY, SIZE = 900_001, 11, 12, 13
X, Y = [2.5, 46.0, 1.25e3], [0.125, -0.0625, 1.5e-7]


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    """Return a file of one complex load and one bound, typed here."""
    path = tmp_path_factory.mktemp("deck") / "lines.bdf"
    text = [darea(AREA, 1001, 4, 1000.0), rload1(5, AREA, REAL, IMAGINARY), rload2(6, AREA, SIZE)]
    tables = [tabled1(REAL, X, Y), tabled1(IMAGINARY, X, [-y for y in Y]), tabled1(SIZE, X, [abs(y) for y in Y])]
    path.write_text("".join([*text, *(line for table in tables for line in table)]), encoding="ascii")
    return path


def padded(y):
    return [0.0, 0.0, *y, 0.0, 0.0]


ENDS = [2.495, 2.4975, *X, 1251.25, 1252.5]


def test_cards_stand_in_their_columns(deck):
    """Truth: the format. Eight columns a small field, sixteen a large one, a point in each real number."""
    found = cards(deck)
    assert [name for name, _ in found] == ["DAREA", "RLOAD1", "RLOAD2", "TABLED1", "TABLED1", "TABLED1"]
    assert found[0][1][:4] == [AREA, 1001, 4, 1000.0]
    assert found[1][1][:6] == [5, AREA, None, None, REAL, IMAGINARY]
    assert found[2][1][:5] == [6, AREA, None, None, SIZE]
    table = found[3][1]
    assert table[:8] == [REAL, "LINEAR", "LINEAR", None, None, None, None, None]
    end = table.index("ENDT")
    assert table[8:end:2] == pytest.approx(ENDS, rel=1e-9)
    assert table[9:end:2] == pytest.approx(padded(Y), rel=1e-9)
    assert set(table[end + 1 :]) <= {None}


@pytest.mark.parametrize("number", [1.0, -1.0, 1000.0, 0.10197162, 1e-3, 1.23456e-12, -1.23456e12, 123456.7, 1e6, -1e7])
def test_real_numbers_fit_a_small_field(number):
    """Truth: the number itself, to the digits that eight columns leave."""
    card = darea(1, 2, 3, number)
    field = card.rstrip("\n")[32:]
    assert len(field) <= 8
    assert value(field) == pytest.approx(number, rel=1e-2 if abs(number) < 1e-9 or abs(number) > 1e9 else 1e-5)


def test_pynastran_reads_them(deck):
    """Truth: pyNastran."""
    try:
        from pyNastran.bdf.bdf import BDF
    except (ImportError, AttributeError):  # versions that ask NumPy for what it no longer has
        pytest.skip("no pyNastran here that works with this NumPy")
    model = BDF(debug=None)
    model.read_bdf(str(deck), xref=False, punch=True)
    (area,) = model.dareas.values()
    assert (area.sid, area.node_ids, area.components, area.scales) == (AREA, [1001], [4], [1000.0])
    complex_load, bound = model.dload_entries[5][0], model.dload_entries[6][0]
    assert (complex_load.type, complex_load.excite_id, complex_load.tc, complex_load.td) == (
        "RLOAD1",
        AREA,
        REAL,
        IMAGINARY,
    )
    assert (bound.type, bound.excite_id, bound.tb) == ("RLOAD2", AREA, SIZE)
    np.testing.assert_allclose(model.tables_d[REAL].x, ENDS, rtol=1e-9)
    np.testing.assert_allclose(model.tables_d[REAL].y, padded(Y), rtol=1e-9)
    np.testing.assert_allclose(model.tables_d[SIZE].y, padded(map(abs, Y)), rtol=1e-9)


def test_pyyeti_reads_them(deck):
    """Truth: pyYeti."""
    nastran = pytest.importorskip("pyyeti.nastran")
    tables = nastran.rdtabled1(str(deck))
    np.testing.assert_allclose(tables[REAL], np.column_stack([ENDS, padded(Y)]), rtol=1e-9)
    assert sorted(tables) == [REAL, IMAGINARY, SIZE]
    (area,) = nastran.rdcards(str(deck), "darea")
    assert area[:4].tolist() == [AREA, 1001, 4, 1000.0]
    (load,) = nastran.rdcards(str(deck), "rload1", blank=-1)
    assert load[:6].tolist() == [5, AREA, -1, -1, REAL, IMAGINARY]


def test_pyyeti_reads_what_was_exported(tables):
    """Truth: pyYeti beside the strict reader here."""
    found = pytest.importorskip("pyyeti.nastran").rdtabled1(str(tables.folder / "lines.bdf"))
    curves = {fields[0]: pairs(fields) for name, fields in cards(tables.folder / "lines.bdf") if name == "TABLED1"}
    assert list(found) == list(curves)
    for table, curve in curves.items():
        np.testing.assert_allclose(found[table], np.column_stack(curve), rtol=1e-9)


def test_the_loads_are_the_lines(tables):
    """Truth: lines.csv. At each rate the load of an order, complex by RLOAD1, is its line; that of RLOAD2 its bound."""
    lines = rows_by_line(tables.folder / "lines.csv")
    found = cards(tables.folder / "lines.bdf")
    curves = {fields[0]: pairs(fields) for name, fields in found if name == "TABLED1"}
    loads = [(name, fields) for name, fields in found if name.startswith("RLOAD")]
    ids = [fields[0] for _, fields in loads]
    assert len(set(ids)) == len(ids)
    assert {fields[1] for _, fields in loads} == {fields[0] for name, fields in found if name == "DAREA"}
    seen = 0
    for name, fields in loads:
        x, y = curves[fields[4]]
        assert np.all(np.diff(x) > 0.0)
        assert y[[0, 1, -2, -1]].tolist() == [0.0] * 4
        for f, size in zip(x[2:-2], y[2:-2], strict=True):
            line, bound = lines[round(f, 6)]
            if name == "RLOAD1":
                imaginary = dict(zip(*curves[fields[5]], strict=True))[f]
                assert is_one_of(complex(size, imaginary), line)
            else:
                assert is_one_of(size, bound)
            seen += 1
    assert seen > 40  # at two rates


def pairs(fields):
    numbers = fields[8 : fields.index("ENDT")]
    return np.array(numbers[::2]), np.array(numbers[1::2])


def rows_by_line(path):
    """Return complex lines and bounds by their frequency, rounded; several where orders of two rates meet."""
    found = {}
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            phase = math.radians(float(row["phase_deg"] or 0.0))
            line = float(row["amplitude_Nm"]) * complex(math.cos(phase), math.sin(phase))
            cell = found.setdefault(round(float(row["frequency_Hz"]), 6), ([], []))
            cell[0].append(line)
            cell[1].append(float(row["bound_Nm"]))
    return found


def is_one_of(number, numbers):
    """Return whether a number is one of some, to nine digits."""
    return any(abs(number - one) <= 1e-9 * abs(one) + 1e-15 for one in numbers)
