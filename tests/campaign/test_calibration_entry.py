"""The calibration of a table: what is read, what is refused with its place. Truth: the numbers that were written."""

import numpy as np
import pytest

from mechid.campaign.calibration_entry import read_calibration
from mechid.campaign.place import Place
from mechid.errors import InputFileError

PLACE = Place("campaign.toml", "bench.calibration")
MATRIX = np.diag([10.0, 10.0, 20.0, 500.0, 500.0, 300.0]) + 0.1 * np.arange(36.0).reshape(6, 6)
UNITS = {"input_unit": "V", "output_unit": ["N", "N*mm"], "uncertainty_percent": 0.5}


def read(folder=None, **entry):
    return read_calibration({"matrix": MATRIX.tolist(), **UNITS, **entry}, PLACE, folder)


def test_a_matrix_of_voltages_in_si():
    found = read(input_unit="mV")
    wanted = MATRIX * np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])[:, None] / 1e-3
    np.testing.assert_allclose(found.matrix, wanted, rtol=1e-12)
    assert (found.in_volts, found.uncertainty) == (True, 0.005)


def test_a_matrix_of_loads_has_the_units_of_both_sides():
    """Truth: N per N, N per mN m; N mm per N, N mm per mN m."""
    found = read(input_unit=["N", "mN*m"])
    assert not found.in_volts
    np.testing.assert_allclose(found.matrix[:3, :3], MATRIX[:3, :3])
    np.testing.assert_allclose(found.matrix[:3, 3:], 1e3 * MATRIX[:3, 3:])
    np.testing.assert_allclose(found.matrix[3:, :3], 1e-3 * MATRIX[3:, :3])
    np.testing.assert_allclose(found.matrix[3:, 3:], MATRIX[3:, 3:])


@pytest.mark.parametrize(
    ("delimiter", "header"), [(",", "Fx,Fy,Fz,Mx,My,Mz\n"), (";", "# certificate 12\n"), ("\t", "")]
)
def test_a_file(tmp_path, delimiter, header):
    rows = "\n".join(delimiter.join(map(repr, row)) for row in MATRIX.tolist())
    (tmp_path / "c.csv").write_text(header + rows + "\n")
    found = read_calibration({"file": "c.csv", **UNITS}, PLACE, tmp_path)
    np.testing.assert_allclose(found.matrix[:3], MATRIX[:3])
    assert found.source == "c.csv"


SINGULAR = MATRIX.copy()
SINGULAR[4] = 2.0 * SINGULAR[3]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            {"matrix": SINGULAR.tolist()},
            r"matrix: the matrix of campaign.toml is singular: its rows of moment_x, moment_y",
        ),
        ({"matrix": (MATRIX * (np.arange(6) != 2)).tolist()}, "is singular: the column of force_z is zero"),
        ({"matrix": MATRIX[:5].tolist()}, "matrix: found 5 rows; write six rows of six numbers"),
        ({"matrix": [*MATRIX[:5].tolist(), [1.0, 2.0]]}, r"matrix\[5\]: found 2 numbers; write six rows"),
        ({"matrix": [*MATRIX[:5].tolist(), ["a", 1, 1, 1, 1, 1]]}, r'matrix\[5\]\[0\]: found "a"'),
        ({"input_unit": "A"}, 'input_unit: "A" is no unit of a voltage; write input_unit = "V"'),
        (
            {"output_unit": ["N", "N"]},
            r'output_unit\[1\]: "N" is no unit of a moment; write output_unit = \["N", "N\*m"\]',
        ),
        ({"output_unit": "N"}, 'output_unit: found "N"; write output_unit ='),
        ({"file": "c.csv"}, "found both matrix and file; write one"),
        ({"uncertainty_percent": -1.0}, "uncertainty_percent: found -1; write 0 or above"),
        ({"gain": 2.0}, "gain: unknown key"),
    ],
)
def test_what_is_refused(entry, message):
    with pytest.raises(InputFileError, match=r"campaign.toml: bench.calibration.*" + message):
        read(**entry)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("input_unit", 'input_unit: missing; write input_unit = "V" where the channels are voltages'),
        ("output_unit", r'output_unit: missing; write output_unit = \["N", "N\*m"\]'),
        ("uncertainty_percent", "uncertainty_percent: missing; write the standard error"),
        ("matrix", "found neither matrix nor file"),
    ],
)
def test_what_is_missing_is_named_with_the_line_to_write(key, message):
    entry = {"matrix": MATRIX.tolist(), **UNITS}
    del entry[key]
    with pytest.raises(InputFileError, match=message):
        read_calibration(entry, PLACE, None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2,3,4,5,6\n" * 4, "c.csv: found 4 rows of numbers; write six rows"),
        ("1,2,3,4,5,6\n" * 5 + "1,2,x,4,5,6\n", 'c.csv: line 6: found "x"; write six rows'),
        ("1,2,3,4,5,6\n" * 5 + "1,2,3\n", "c.csv: line 6: found 3 cells"),
        ("1,2,3,4,5,6\n" * 6, "file: c.csv is singular"),
        (None, "c.csv: there is no such file beside campaign.toml"),
    ],
)
def test_what_is_refused_of_a_file(tmp_path, text, message):
    if text is not None:
        (tmp_path / "c.csv").write_text(text)
    with pytest.raises(InputFileError, match=message):
        read_calibration({"file": "c.csv", **UNITS}, PLACE, tmp_path)
