"""The declared response of a table. Truth: what was written, and the rules of docs/emission.md."""

import pytest

from mechid.campaign.place import Place
from mechid.campaign.table_response_entry import DAMPING_UNCERTAINTY, TableMode, read_table_response
from mechid.errors import InputFileError

PLACE = Place("campaign.toml", "bench.table_response")


def mode(direction="fx", **more):
    return {"direction": direction, "frequency_hz": 930.0, "damping": 0.02, **more}


def read(folder=None, **entry):
    return read_table_response({"uncertainty_percent": 1.0, **entry}, PLACE, folder)


def test_modes():
    found = read(modes=[mode(), mode("mz", share=0.6), mode("mz", frequency_hz=1200.0, share=0.4)])
    assert found.modes[0] == TableMode(component=0, frequency_hz=930.0, damping=0.02, share=1.0)
    assert [(m.component, m.frequency_hz, m.share) for m in found.modes[1:]] == [(5, 930.0, 0.6), (5, 1200.0, 0.4)]
    assert (found.uncertainty, found.damping_uncertainty, found.file) == (0.01, DAMPING_UNCERTAINTY, None)


def test_a_file_with_units(tmp_path):
    (tmp_path / "t.csv").touch()
    found = read(tmp_path, file="t.csv", input_unit=["N", "N*m"], output_unit=["mN", "N*mm"])
    assert found.file == tmp_path / "t.csv"
    assert found.output_factors.tolist() == [1e-3] * 6
    assert found.input_factors.tolist() == [1.0] * 6


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({}, "found neither modes nor file"),
        ({"file": "t.csv", "modes": [mode()]}, "found both modes and file"),
        ({"file": "t.csv"}, "file: t.csv: there is no such file beside campaign.toml"),
        ({"file": "t.xlsx"}, r'file: no reader for ".xlsx"; mechid reads .csv, .mat, .uff, .unv'),
        ({"file": "t.csv", "input_unit": ["N", "N*m"]}, "input_unit stands alone; write both"),
        ({"modes": [mode()], "input_unit": ["N", "N*m"]}, "input_unit: applies to a file only"),
        ({"file": "t.csv", "damping_uncertainty_percent": 3.0}, "damping_uncertainty_percent: applies to modes only"),
        ({"modes": []}, "modes: .*write a list of tables"),
        ({"modes": [mode("f")]}, r'modes\[0\].direction: found "f"'),
        ({"modes": [mode(damping=2.0)]}, r"modes\[0\].damping: found 2; write the share of critical damping"),
        ({"modes": [mode(frequency_hz=0.0)]}, r"modes\[0\].frequency_hz: found 0; write a number above 0 in Hz"),
        ({"modes": [{"direction": "fx", "damping": 0.1}]}, r"modes\[0\].frequency_hz: missing"),
        ({"modes": [mode(), mode(share=0.5)]}, r"modes\[0\].share: missing; fx has 2 modes"),
        ({"modes": [mode(share=0.5), mode(share=0.6)]}, "modes: the shares of fx add up to 1.1"),
        ({"modes": [mode()], "uncertainty_percent": 0.0}, "uncertainty_percent: found 0; write a number above 0"),
    ],
)
def test_what_is_refused(tmp_path, entry, message):
    with pytest.raises(InputFileError, match=r"campaign.toml: bench.table_response.*" + message):
        read(tmp_path, **entry)


def test_the_uncertainty_has_to_be_stated():
    with pytest.raises(InputFileError, match="uncertainty_percent: missing; write its standard error"):
        read_table_response({"modes": [mode()]}, PLACE, None)
