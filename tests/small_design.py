"""A small design: a campaign of one record that has no file, three rates to choose from."""

import shutil
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from mechid.cli.app import app
from mechid.designs import loss_table
from once import once

SMALL = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [23.0, 46.0, 600.0]
start_angles_deg = [45.0]
sweeps_s = []
[limits]
between_s = 1.0
total_s = 6.0
[prior]
mechanisms = 2
"""
PLANNED = """
mechanism = "mechanism.toml"
[[record]]
name = "micro_46"
command = { stepping = "micro", microsteps = 16, rate = 46.0 }
"""


def plan(folder):
    """Write a campaign of one record that has no file, and a small design file, beside the bench's mechanism."""
    (folder / "campaign.toml").write_text(PLANNED, encoding="utf-8")
    (folder / "design.toml").write_text(SMALL, encoding="utf-8")
    return folder


def design(bench, tmp_path_factory):
    """Return the folder of its design, and what the shell showed, made once in a run of the tests; not to be changed.

    `bench` is the folder whose mechanism it takes.
    """
    return once(tmp_path_factory, "small_design", lambda: _designed(bench, tmp_path_factory.mktemp("planned")))


def shorten_loss_table(patched):
    """Leave one factor of each kind in the table of step loss; tests/designs/test_step_loss.py holds its rows."""
    few = replace(loss_table.RATE, inertia_factors=(2.0,), voltage_factors=(0.8,), torque_shares=(0.2,))
    patched.setattr(loss_table, "RATE", few)


def _designed(bench, folder):
    shutil.copy(bench / "mechanism.toml", folder)
    with pytest.MonkeyPatch.context() as patched:
        shorten_loss_table(patched)
        result = CliRunner().invoke(app, ["design", str(plan(folder)), "--out", str(folder / "out")])
    assert result.exit_code == 0, result.stderr
    return folder / "out", result.stdout
