"""Files of table responses. Truth: the oscillators that were written into them."""

import numpy as np
import pytest
from scipy.io import savemat

from mechid.campaign.place import Place
from mechid.campaign.table_response_entry import DIRECTIONS, read_table_response
from mechid.emissions.table_response_file import table_response_of
from mechid.errors import InputFileError

F = np.arange(10.0, 1000.0, 5.0)
UNITS = {"input_unit": ["N", "N*m"], "output_unit": ["N", "N*m"]}


def oscillator(f0):
    return 1.0 / (1.0 - (F / f0) ** 2 + 0.04j * F / f0)


def read(folder, name, **more):
    entry = {"file": name, "uncertainty_percent": 1.0, **more}
    return table_response_of(read_table_response(entry, Place("campaign.toml", "bench.table_response"), folder))


def write_csv(folder, columns, name="t.csv", frequency="frequency_Hz", f=F):
    header = ",".join([frequency, *columns])
    np.savetxt(folder / name, np.column_stack([f, *columns.values()]), delimiter=",", header=header, comments="")


def parts(name, values, unit=""):
    return {f"{name}_re{unit}": values.real, f"{name}_im{unit}": values.imag}


def test_a_csv_file_of_axes_and_a_pair(tmp_path):
    """Truth: mN m per N is a thousandth of N m per N."""
    write_csv(
        tmp_path,
        {
            **parts("fx", oscillator(900), " [N/N]"),
            **parts("mx", oscillator(950), " [1]"),
            **parts("mx_fx", oscillator(970), " [mN*m/N]"),
        },
    )
    found = read(tmp_path, "t.csv")
    assert found.measured == (0, 3)
    np.testing.assert_allclose(found.values[:, 0, 0], oscillator(900))
    np.testing.assert_allclose(found.values[:, 3, 3], oscillator(950))
    np.testing.assert_allclose(found.values[:, 3, 0], 1e-3 * oscillator(970))
    assert not found.values[:, 0, 3].any()


def test_magnitude_and_phase(tmp_path):
    h = oscillator(900)
    write_csv(tmp_path, {"fz_mag": np.abs(h), "fz_phase_deg": np.degrees(np.angle(h))})
    np.testing.assert_allclose(read(tmp_path, "t.csv", **UNITS).values[:, 2, 2], h, rtol=1e-9)


def test_frequencies_in_their_unit(tmp_path):
    write_csv(tmp_path, parts("fz", oscillator(900), " [1]"), frequency="frequency [kHz]", f=F / 1e3)
    np.testing.assert_allclose(read(tmp_path, "t.csv").frequency_hz, F)


WHOLE = np.array([[oscillator(900 + 10 * i + 50 * k) * (0.03 if i != k else 1.0) for k in range(6)] for i in range(6)])


@pytest.mark.parametrize("layout", ["first", "last"])
def test_a_mat_file_of_all_pairs(tmp_path, layout):
    """Truth: in mN m of N m, N of mN."""
    savemat(
        tmp_path / "t.mat", {"frequency_hz": F, "response": WHOLE if layout == "last" else np.moveaxis(WHOLE, -1, 0)}
    )
    found = read(tmp_path, "t.mat", input_unit=["mN", "N*m"], output_unit=["N", "mN*m"])
    factor = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])[:, None] / np.array([1e-3] * 3 + [1.0] * 3)
    np.testing.assert_allclose(found.values, np.moveaxis(WHOLE * factor[:, :, None], -1, 0), rtol=1e-12)


def test_a_mat_file_of_axes(tmp_path):
    savemat(tmp_path / "t.mat", {"frequency_hz": F, "response": WHOLE[range(6), range(6)].T})
    found = read(tmp_path, "t.mat", **UNITS).values
    np.testing.assert_allclose(found[:, 4, 4], WHOLE[4, 4])
    assert not found[:, 4, 3].any()


def write_uff(path, pairs, **more):
    pyuff = pytest.importorskip("pyuff")
    for (response, load), values in pairs.items():
        options = {
            "func_type": 4,
            "ordinate_spec_data_type": 9,
            "ordinate_axis_units_lab": "N" if abs(response) < 4 else "N*m",
            "orddenom_axis_units_lab": "N" if abs(load) < 4 else "N*m",
            **more,
        }
        made = pyuff.prepare_58(
            binary=0,
            rsp_node=1,
            ref_node=1,
            rsp_dir=response,
            ref_dir=load,
            x=F,
            data=values,
            id1="made up",
            rsp_ent_name="table",
            ref_ent_name="table",
            abscissa_spacing=1,
            abscissa_spec_data_type=18,
            orddenom_spec_data_type=13,
            **options,
        )
        pyuff.UFF(str(path)).write_sets(made, "add" if path.exists() else "overwrite")


def test_a_universal_file(tmp_path):
    """Truth: the response to a hammer's blow along -y has the opposite sign."""
    write_uff(
        tmp_path / "t.uff",
        {(1, 1): oscillator(900), (2, -2): -oscillator(950), (6, 6): oscillator(990), (6, 1): 0.01 * oscillator(900)},
    )
    found = read(tmp_path, "t.uff")
    assert [DIRECTIONS[k] for k in found.measured] == ["fx", "fy", "mz"]
    np.testing.assert_allclose(found.values[:, 1, 1], oscillator(950), rtol=1e-5)
    np.testing.assert_allclose(found.values[:, 5, 0], 0.01 * oscillator(900), rtol=1e-5)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"ordinate_axis_units_lab": "NONE"}, r'fx per fx: states no unit; write input_unit = \["N", "N\*m"\]'),
        ({"ordinate_axis_units_lab": "N*m"}, r'fx per fx: unit "N\*m/\(N\)" is none of fx per fx'),
        ({"ordinate_spec_data_type": 12}, "fx per fx: is an acceleration per load"),
        ({"func_type": 1}, "holds no frequency response in a data set 58"),
    ],
)
def test_what_is_refused_of_a_universal_file(tmp_path, more, message):
    write_uff(tmp_path / "t.uff", {(1, 1): oscillator(900)}, **more)
    with pytest.raises(InputFileError, match=f"campaign.toml: bench.table_response.file: t.uff.*{message}"):
        read(tmp_path, "t.uff")


BAD = oscillator(900).copy()
BAD[3] = np.inf


@pytest.mark.parametrize(
    ("columns", "f", "message"),
    [
        (parts("fx", oscillator(900)), F, "fx_re.*: states no unit; write input_unit"),
        (parts("fx", oscillator(900), " [V/N]"), F, 'unit "V/N" is none of fx per fx; expected N/'),
        (parts("fx_fy", oscillator(900), " [1]"), F, "has fx per fy, but not fx per fx"),
        (parts("force", oscillator(900), " [1]"), F, '"force" is no response of a table; name it by directions'),
        (parts("fx", oscillator(900)[:5], " [1]"), F[:5], "5 frequencies; a response needs at least 8"),
        (parts("fx", oscillator(900), " [1]"), F[::-1], "frequency 990 Hz after 995 Hz; sort the points"),
        ({"fx_re [1]": oscillator(900).real}, F, 'no column "fx_im"'),
        (
            {**parts("fx", oscillator(900), " [1]"), **parts("fx_fx", oscillator(900), " [1]")},
            F,
            '"fx_fx" stands there twice',
        ),
    ],
)
def test_what_is_refused_of_a_csv_file(tmp_path, columns, f, message):
    write_csv(tmp_path, columns, f=f)
    with pytest.raises(InputFileError, match=f"campaign.toml: bench.table_response.file: t.csv.*{message}"):
        read(tmp_path, "t.csv")


@pytest.mark.parametrize(
    ("content", "more", "message"),
    [
        (
            {"frequency_hz": F},
            UNITS,
            'no numbers under "response"; expected frequency_hz and response, found frequency_hz',
        ),
        ({"frequency_hz": F, "response": WHOLE[:5]}, UNITS, "response is 5x6x198; expected 198x6x6"),
        ({"frequency_hz": F, "response": WHOLE}, {}, "response: states no unit; write input_unit"),
        (
            {"frequency_hz": F, "response": WHOLE * np.where(F == 20.0, np.nan, 1.0)},
            UNITS,
            "holds a value that is not finite",
        ),
    ],
)
def test_what_is_refused_of_a_mat_file(tmp_path, content, more, message):
    savemat(tmp_path / "t.mat", content)
    with pytest.raises(InputFileError, match=f"bench.table_response.file: t.mat.*{message}"):
        read(tmp_path, "t.mat", **more)


@pytest.mark.parametrize("name", ["t.mat", "t.uff"])
def test_a_damaged_file(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00nothing of the kind")
    with pytest.raises(InputFileError, match=f"bench.table_response.file: {name}"):
        read(tmp_path, name, **UNITS)
