"""A small design: a campaign of one record that has no file, three rates to choose from."""

import shutil

from typer.testing import CliRunner

from mechid.cli.app import app
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


def _designed(bench, folder):
    shutil.copy(bench / "mechanism.toml", folder)
    result = CliRunner().invoke(app, ["design", str(plan(folder)), "--out", str(folder / "out")])
    assert result.exit_code == 0, result.stderr
    return folder / "out", result.stdout
