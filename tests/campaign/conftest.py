"""A small campaign on disk, from which each test changes one thing."""

import math
import re

import pytest

from mechid.errors import InputFileError

MECHANISM = """\
[stepper]
poles = 100
peak_voltage = 5.7
rotor_inertia = 8.9e-6
coil_resistance = { value = 9.5, min = 5.0, max = 20.0 }
coil_inductance = 0.0229
torque_constant = 0.277

[[stepper.detent]]
period_deg = 1.8
amplitude = { value = 0.0, min = 0.0, max = 0.1 }
phase_deg = { value = 30.0, min = -180.0, max = 180.0 }

[friction]
static = 0.03
coulomb = { value = 0.0265, min = 0.0, max = 0.1, sigma = 0.01 }
viscous = 9.74e-4

[gear]
ratio = -50
stiffness = { value = 2200.0, min = 300.0, max = 5000.0 }
damping = 0.48

[load]
inertia = 0.010534

[housing]
gain = 2.0
frequency = { value = 5000.0, min = 2500.0, max = 9000.0 }
damping = 0.05
"""

CAMPAIGN = """\
mechanism = "mechanism.toml"

[[record]]
name = "full_46"
file = "full_46.csv"
command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }

[[record]]
name = "sweep"
file = "sweep.csv"
use = "validate"
command = { stepping = "micro", microsteps = 16, rate_profile = [[0.0, 0.0], [1.0, 20.0]] }
time_offset_s = { value = 0.0, min = -0.002, max = 0.002 }
"""


def record_text(rate_hz=1000.0, samples=1001, start_s=0.0, frequency_hz=7.0):
    """Return a CSV record of a sine, no two of different arguments alike."""
    times = (start_s + k / rate_hz for k in range(samples))
    rows = (f"{t:.6f},{math.sin(2.0 * math.pi * frequency_hz * t):.6e}" for t in times)
    return "\n".join(["time_s,torque_Nm", *rows]) + "\n"


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the campaign, its mechanism and its records."""
    (tmp_path / "mechanism.toml").write_text(MECHANISM)
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    (tmp_path / "full_46.csv").write_text(record_text(frequency_hz=46.0))
    (tmp_path / "sweep.csv").write_text(record_text())
    return tmp_path


@pytest.fixture
def changed(folder):
    """Return a function that replaces text in one of the folder's files and returns the file's path."""

    def change(name, old, new):
        path = folder / name
        content = path.read_text()
        assert content.count(old) >= 1, f"{old!r} is not in {name}"
        path.write_text(content.replace(old, new, 1))
        return path

    return change


@pytest.fixture
def refused():
    """Return a function that sees reading refused: in one line that begins as told, with the exit code of a file."""

    def see(message, read, *given):
        with pytest.raises(InputFileError, match=f"^{re.escape(message)}") as caught:
            read(*given)
        assert "\n" not in str(caught.value)
        assert caught.value.exit_code == 3

    return see


@pytest.fixture
def write_record():
    """Return the function that makes the text of a record."""
    return record_text
