"""Document and files. Truth: the table itself, read back from CSV, header and TOML."""

import re
import tomllib

import numpy as np


def test_the_files_hold_the_table_and_the_rates(found, tmp_path):
    names = {path.name for path in found.write(tmp_path)}
    assert {"quiet.json", "table.csv", "table.h", "rates.csv", "rates.toml", "quiet.md", "quiet.html"} <= names
    read = np.loadtxt(tmp_path / "table.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(read[:, 1:], found.table)
    header = (tmp_path / "table.h").read_text()
    for phase, name in enumerate("ab"):
        body = re.search(rf"int16_t mechid_table_{name}\[MECHID_TABLE_LENGTH\] = {{(.*?)}};", header, re.DOTALL)[1]
        assert [int(code) for code in body.split(",") if code.strip()] == found.rounded.codes[:, phase].tolist()
    rates = tomllib.loads((tmp_path / "rates.toml").read_text())
    assert {band["stepping"] for band in rates["band"]} == {"micro8", "table"}
    assert (tmp_path / "rates.csv").read_text().startswith("stepping,rate,rms_Nm,bound_Nm,verdict\nmicro8,28")


def test_the_text_states_gain_and_range(found):
    assert "RMS torque down by" in str(found)
    assert "at the design rate with 10 bits, and lower at all rates of the range." in str(found)
    assert "QuietDrive: 32 microsteps" in repr(found)
