"""Requirements as they are written. Truth: the file's own numbers, converted by hand."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import xlsxwriter

from emission_bench import requirement
from mechid.campaign.place import Place
from mechid.errors import InputFileError
from mechid.specification.requirement_entry import read_requirements


def read(text, folder=Path()):
    return read_requirements(tomllib.loads(text), Place("s.toml"), folder)


def test_limits_become_si():
    (one,) = read(requirement(unit="mN", mask=((10.0, 5.0), (100.0, 50.0))))
    assert one.mask.limits == pytest.approx([0.005, 0.05])
    assert one.mask.limit_at(np.array([5.0, 10.0, np.sqrt(1000.0), 100.0]))[1:] == pytest.approx(
        [0.005, 0.005 * 10**0.5, 0.05]
    )
    assert one.confidence == 0.95
    assert one.holds_at(1e3)


def test_a_density_may_be_given_by_its_root():
    (one,) = read(requirement(kind="psd", unit="mN/Hz^0.5", mask=((10.0, 2.0), (100.0, 2.0))))
    assert one.mask.limits == pytest.approx([4e-6, 4e-6])
    (one,) = read(requirement(direction="mz", kind="psd", unit="N^2*m^2/Hz", mask=((10.0, 2.0), (100.0, 2.0))))
    assert one.mask.limits == pytest.approx([2.0, 2.0])


def test_a_margin_lowers_the_limit():
    assert read(requirement(more="margin_db = 6.0"))[0].margin_factor == pytest.approx(0.501, abs=1e-3)
    assert read(requirement(kind="psd", unit="N^2/Hz", more="margin_db = 3.0"))[0].margin_factor == pytest.approx(
        0.501, abs=1e-3
    )


def test_steps_hold_up_to_the_next_point():
    (one,) = read(requirement(mask=((10.0, 1.0), (50.0, 2.0), (100.0, 3.0)), more='interpolation = "step"'))
    assert one.mask.limit_at(np.array([10.0, 49.9, 50.0, 100.0, 101.0])).tolist() == [1.0, 1.0, 2.0, 3.0, np.inf]
    assert read(requirement(kind="rms"))[0].mask.bands == [(20.0, 500.0, 0.1)]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_mask_file_says_its_units(tmp_path, separator):
    lines = ("# a comment", f"frequency [kHz]{separator}limit [mN]", f"0.01{separator}5", f"0.1{separator}50")
    (tmp_path / "m.csv").write_text("\n".join(lines))
    (one,) = read('[[requirement]]\nname = "r"\ndirection = "fx"\nkind = "amplitude"\nmask_file = "m.csv"\n', tmp_path)
    assert one.mask.frequencies_hz == pytest.approx([10.0, 100.0])
    assert one.mask.limits == pytest.approx([0.005, 0.05])


def test_a_mask_may_be_a_sheet(tmp_path):
    with xlsxwriter.Workbook(str(tmp_path / "m.xlsx")) as book:
        sheet = book.add_worksheet()
        for k, row in enumerate([("f [Hz]", "limit [N*m]"), (10.0, 0.5), (100.0, 5.0)]):
            sheet.write_row(k, 0, row)
    (one,) = read('[[requirement]]\nname = "r"\ndirection = "mx"\nkind = "amplitude"\nmask_file = "m.xlsx"\n', tmp_path)
    assert one.mask.limits == pytest.approx([0.5, 5.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            requirement(mask=((10.0, 1.0), (5.0, 1.0))),
            r"requirement\[0\].mask\[1\]: 5 Hz falls below 10 Hz; write the points",
        ),
        (requirement(mask=((10.0, 1.0), (10.0, 2.0))), r'mask\[1\]: 10 Hz repeats 10 Hz.* interpolation = "step"'),
        (requirement(mask=((10.0, 1.0), (20.0, 0.0))), r"mask\[1\]: found \[20, 0\]; write two numbers above 0"),
        (requirement(mask=((10.0, 1.0),)), r"mask: found .*; write two points or more"),
        (requirement().replace('unit = "N"\n', ""), r'requirement\[0\].unit: missing; write the unit .* unit = "mN"'),
        (requirement(unit="N*m"), r'unit: found "N\*m"; write a unit of N, as "mN"'),
        (requirement(direction="fw"), r'direction: found "fw"; write one of "fx", "fy"'),
        (requirement(kind="peak"), r'kind: found "peak"; did you mean "band_peak"'),
        (requirement(more="confidence = 95"), "confidence: found 95; write a share"),
        (requirement(more="rates = [[60.0, 20.0]]"), r"rates\[0\]: found \[60, 20\]; write the lower rate first"),
        (requirement(more="resolution_hz = 1.0"), 'resolution_hz: it is the bin width of kind = "psd"'),
        (requirement(kind="band_peak", more="exclude_mains = true"), "exclude_mains: a peak over time holds all lines"),
        (
            requirement(kind="rms", more='interpolation = "log-log"'),
            'interpolation: found "log-log"; kind = "rms" has one',
        ),
        (requirement(more="margin = 3"), 'margin: unknown key; did you mean "margin_db"'),
        (requirement() + requirement(), r'requirement\[1\].name: "r" is also the name of requirement\[0\]'),
        ("", "no requirement; write one"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_place_and_what_to_write(text, message):
    with pytest.raises(InputFileError, match=message):
        read(text)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("f,limit [N]\n1,2\n3,4\n", 'column 1: no unit in "f"; write one header line with both units'),
        ("f [Hz],limit\n1,2\n3,4\n", 'column 2: no unit in "limit"'),
        ("f [s],limit [N]\n1,2\n3,4\n", '"s" is no unit of frequency'),
        ("f [Hz],limit [N]\n1,x\n3,4\n", r"line 2: found \['1', 'x'\]; write two numbers"),
        ("f [Hz],limit [N]\n5,1\n3,4\n", "3 Hz falls below 5 Hz"),
        (None, "m.csv: there is no such file"),
    ],
)
def test_a_wrong_mask_file_is_refused(tmp_path, content, message):
    if content is not None:
        (tmp_path / "m.csv").write_text(content)
    with pytest.raises(InputFileError, match=message):
        read('[[requirement]]\nname = "r"\ndirection = "fx"\nkind = "amplitude"\nmask_file = "m.csv"\n', tmp_path)
