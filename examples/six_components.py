"""Write a SYNTHETIC bench that measures six components, and a budget of them: nothing of it was measured.

    python examples/six_components.py six
    mechid identify six/campaign.toml --out six/fit
    mechid budget six/budget.toml --out six/budget

The drive torque is simulated from the demo's values, without a housing. Beside it stand, about the mounting point:

    moment_x   6 % of the drive torque, as of an axis that is 3.4 deg off
    moment_y   a line at order 2 of the steps, in a fixed phase to the steps
    force_x    a line at order 1, its amplitude growing with the rate squared
    force_y    a line at order 1, in another phase
    force_z    a line at order 2 that wanders against the steps, as of a fan; and one at order 1.25

The table's reference point is 60 mm below the mounting point and 20 mm beside it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np

import mechid
from mechid.budgets.example import STRUCTURE
from mechid.campaign import campaign_text, catalogue_mechanism, load_campaign, mechanism_text
from mechid.campaign.bench import TRUTH
from mechid.campaign.templates import RecordDraft

SAMPLE_RATE_HZ, SECONDS = 2000.0, 8.0
RATES = (18.0, 19.0, 20.0, 21.0, 22.0)
POINT_M = (0.02, 0.0, 0.06)
NOISE_NM, NOISE_N = 5e-4, 5e-3
FREE = ("stepper.torque_constant", "gear.stiffness", "gear.damping")
MISALIGNED = 0.06
LINES = {"moment_y": (2.0, 2e-3, 30.0), "force_x": (1.0, 0.04, 0.0), "force_y": (1.0, 0.03, 90.0)}
"""Order, amplitude in N m or N at 20 steps/s, phase to the steps in deg."""
WANDERING, UNHEARD = (2.0, 0.03), (1.25, 0.02)
"""Of force_z: order and amplitude in N of a line without a phase to the steps, and of one where the model has none."""
COLUMNS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
CHANNELS = """\
channels = [
  { quantity = "torque", column = "Mz", unit = "N*m" },
  { quantity = "force_x", column = "Fx", unit = "N" },
  { quantity = "force_y", column = "Fy", unit = "N" },
  { quantity = "force_z", column = "Fz", unit = "N" },
  { quantity = "moment_x", column = "Mx", unit = "N*m" },
  { quantity = "moment_y", column = "My", unit = "N*m" },
]
"""
BENCH = f"""
[bench]
drive_axis = "z"                        # positive torque turns about the table's z
mounting_point_m = {list(POINT_M)}    # from the table's reference point, along the table's axes
"""
DIRECTIONS = (
    "{ tx = 0.1, ty = 0.0, tz = 0.0, rx = 0.0, ry = 0.02 }",
    "{ tx = 0.03, ty = -0.05, tz = 0.08, rx = 0.12, ry = -0.05 }",
    "{ tx = -0.06, ty = 0.04, tz = 0.02, rx = -0.08, ry = 0.15 }",
    "{ tx = 0.02, ty = 0.03, tz = -0.05, rx = 0.05, ry = 0.06 }",
)
"""Of the demo's assumed structure: translations in 1/kg^0.5, rotations in rad/(kg^0.5 m)."""
BUDGET = """\
# SYNTHETIC bench, ASSUMED structure and requirement.
estimate = "fit/estimate.json"

[structure]
file = "structure.toml"
attitude_control = { bandwidth_hz = 0.02, damping = 0.7 }
frame = { x = [0, 1, 0], y = [-1, 0, 0], z = [0, 0, 1] }   # the table's axes in the structure's frame

[[mode]]
name = "scan"
command = { stepping = "micro", microsteps = 16 }
rates = [20.0, 20.5, 21.0]

[[requirement]]
name = "stability"
index = "RPE"
window_s = 0.1
axis = "x"
limit_rad = 2e-6
interpretation = "temporal"
confidence = 0.9973
evaluation_period_s = 600.0
"""


def at_mounting_point(rate: float, time: np.ndarray, torque: np.ndarray, rng: np.random.Generator) -> dict:
    """Return what the mechanism exerts at its mounting point, six components (N,) by name, in N and N m."""
    steps = 2.0 * np.pi * rate * time
    out = {"moment_z": torque, "moment_x": MISALIGNED * torque}
    for name, (order, amplitude, phase_deg) in LINES.items():
        grown = (rate / 20.0) ** 2 if name == "force_x" else 1.0
        out[name] = grown * amplitude * np.cos(order * steps + np.radians(phase_deg))
    wander = np.cumsum(rng.normal(0.0, np.sqrt(2.0 / SAMPLE_RATE_HZ), time.size))
    out["force_z"] = WANDERING[1] * np.cos(WANDERING[0] * steps + wander + rng.uniform(0.0, 2.0 * np.pi))
    out["force_z"] += UNHEARD[1] * np.cos(UNHEARD[0] * steps)
    return out


def at_table(exerted: dict, rng: np.random.Generator) -> np.ndarray:
    """Return what the table measures about its reference point, (N, 6) as `COLUMNS`: M_O = M_P + r x F, and noise."""
    force = np.column_stack([exerted[f"force_{axis}"] for axis in "xyz"])
    moment = np.column_stack([exerted[f"moment_{axis}"] for axis in "xyz"]) + np.cross(POINT_M, force)
    noise = rng.normal(size=(len(force), 6)) * np.repeat([NOISE_N, NOISE_NM], 3)
    return np.hstack([force, moment]) + noise


def main(folder: Path, rates: tuple[float, ...] = RATES) -> None:
    """Write campaign, mechanism, records, structure and budget into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    true = catalogue_mechanism().with_values(TRUTH)
    near = true.with_free(FREE).with_values({name: 1.03 * TRUTH[name] for name in FREE})
    for name, mechanism in (("truth.toml", true), ("mechanism.toml", near)):
        text = re.sub(r"\[housing\][^\[]*", "", mechanism_text(mechanism))
        (folder / name).write_text("# SYNTHETIC\n" + text, encoding="utf-8")
    command = '{{ stepping = "micro", microsteps = 16, rate = {:.1f} }}'
    drafts = [
        RecordDraft(name=f"micro_{rate:g}".replace(".", "_"), file=f"micro_{rate:g}.csv", command=command.format(rate))
        for rate in rates
    ]
    text = campaign_text(drafts, "SYNTHETIC: simulated, not measured.")
    bare, whole = text, re.sub(r"(command = .*\n)", r"\1" + CHANNELS, text) + BENCH
    (folder / "campaign.toml").write_text(bare.replace("mechanism.toml", "truth.toml"), encoding="utf-8")
    campaign = load_campaign(folder, read_records=False, need_files=False)
    for draft, rate, rng in zip(drafts, rates, np.random.default_rng(0).spawn(len(rates)), strict=True):
        run = mechid.simulate(campaign, draft.name, sample_rate_hz=SAMPLE_RATE_HZ, duration_s=SECONDS)
        table = at_table(at_mounting_point(rate, run.time, run.torque, rng), rng)
        rows = np.column_stack([run.time, table])
        header = "time_s," + ",".join(COLUMNS)
        np.savetxt(folder / draft.file, rows, fmt="%.7g", delimiter=",", header=header, comments="")
    (folder / "campaign.toml").write_text(whole, encoding="utf-8")
    modes = iter(DIRECTIONS)
    structure = re.sub(
        r"(line_of_sight = \[[-0-9].*\n)", lambda line: f"{line[1]}directions = {next(modes)}\n", STRUCTURE
    )
    (folder / "structure.toml").write_text(structure, encoding="utf-8")
    (folder / "budget.toml").write_text(BUDGET, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
