"""Example budget file next to an estimate, with an assumed structure, modes and requirements; it runs unchanged."""

from __future__ import annotations

from pathlib import Path

from mechid.writing import write_atomically

BUDGET_NAME, STRUCTURE_NAME = "budget.toml", "structure.toml"

STRUCTURE = """\
# ASSUMED: a free spacecraft of 100 kg m2 with three flexible modes; no real structure.
# Shapes are mass-normalised, in rad/(kg^0.5 m).
axis = "rz"
line_of_sight = ["x", "y"]
[[mode]]
frequency_hz = 0.0
damping = 0.0
interface = 0.1
line_of_sight = [0.1, 0.02]
[[mode]]
frequency_hz = 21.0
damping = 0.005
interface = 0.15
line_of_sight = [-0.04, 0.02]
[[mode]]
frequency_hz = 47.5
damping = 0.005
interface = 0.2
line_of_sight = [0.05, 0.03]
[[mode]]
frequency_hz = 112.0
damping = 0.01
interface = -0.1
line_of_sight = [0.03, -0.06]
"""

BUDGET = """\
# From the identified mechanism to the line of sight: mechid budget budget.toml --out budget
# Structure, flight load and requirements are ASSUMED; put in your own.
estimate = "estimate.json"
axis = "rz"

[flight]
load_inertia = 0.0105               # kg m2, in place of the bench's test mass
# peak_voltage = 5.7                # V
# values = { stepper.coil_resistance = 11.2 }    # any parameter at flight temperature
uncertain = { load.inertia = 1e-4 }              # what is not known exactly: standard deviation, part of the band
spread = { stepper.peak_voltage = 0.06 }         # standard deviation from unit to unit, over temperature

[structure]
file = "structure.toml"             # modes in TOML or CSV, responses in CSV, UFF 58 or MAT, Nastran op2 or op4
attitude_control = { bandwidth_hz = 0.02, damping = 0.7 }

[[mode]]
name = "scan"
command = { stepping = "micro", microsteps = 16 }
rate_range = { from = 10.0, to = 60.0, count = 26 }
duty = 0.7                          # share of the time; what is left over to 1, the mechanism rests

[[mode]]
name = "slew"
command = { stepping = "full", rate = 92.0, start_angle_deg = 45.0 }
duty = 0.02

[[mode]]
name = "run up"
command = { stepping = "micro", microsteps = 16, rate_profile = [[0.0, 0.0], [6.0, 60.0], [8.0, 60.0], [10.0, 0.0]] }
rms_window_s = 0.5
duty = 0.05

[[error]]                           # of other sources
name = "thermal distortion"
kind = "bias"
axis = "x"
size_rad = 5e-8
spread_rad = 2e-8

[[error]]
name = "attitude noise"
kind = "random"
size_rad = 4e-8                     # standard deviation over time
bandwidth_hz = 2.0

[[error]]
name = "reaction wheel"
kind = "periodic"
size_rad = 3e-8                     # amplitude
frequency_hz = 33.0

[[requirement]]
name = "stability in an exposure"
index = "RPE"
window_s = 0.1
axis = "x"
limit_rad = 6e-7
interpretation = "temporal"
confidence = 0.9973
evaluation_period_s = 600.0

[[requirement]]
name = "pointing"
index = "APE"
axis = "cone"
limit_rad = 2e-5
interpretation = "mixed"
confidence = 0.9545
evaluation_period_s = 600.0
"""


def write_example(folder: Path) -> list[Path]:
    """Write budget.toml and structure.toml next to an estimate.json; existing files are kept."""
    written = []
    for name, content in ((BUDGET_NAME, BUDGET), (STRUCTURE_NAME, STRUCTURE)):
        if not (folder / name).exists():
            write_atomically(folder / name, content)
            written.append(folder / name)
    return written
