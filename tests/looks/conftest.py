"""A look at two records: one of two channels, and one with a gap and clipping."""

import numpy as np
import pytest
from typer.testing import CliRunner

from look_records import STEPS, TIME, torque, written
from mechid.cli.app import app
from once import once


@pytest.fixture(scope="session")
def looked(tmp_path_factory):
    """Return the folder of the look, and what was printed."""
    return once(tmp_path_factory, "looked", lambda: _looked(tmp_path_factory.mktemp("look")))


def _looked(folder):
    turns = np.round(STEPS * TIME + 0.1 * np.sin(2.0 * np.pi * STEPS * TIME), 2)
    written(folder / "two.csv", torque(), turns, header="time_s,torque_Nm,ticks")
    gapped = torque(2)
    gapped[5_000:5_020] = np.nan
    written(folder / "gapped.csv", np.clip(gapped, -0.3, 0.3))
    files = [str(folder / name) for name in ("two.csv", "gapped.csv")]
    result = CliRunner().invoke(app, ["look", *files, "--out", str(folder / "out")])
    assert result.exit_code == 0, result.output
    return folder / "out", result.stdout
