"""Lab benches written as files: mechanism.toml, campaign.toml, a CSV of each record, truth.json.

    bench = make_bench(3, folder)
    campaign = load_campaign(folder)

Equal seeds give equal files. The records are made by `lab.plant`, which has nothing of mechid. The files say what a
careful engineer knows: the gear, modes of the load as a finite element model has them, the filter, about when the
trigger comes, the mains, whose clock is right, the range of a record that was clipped.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from incomplete.stepping import edges
from lab.measurement import COLUMNS, MAINS_HZ, POINT_M, measured, recorded
from lab.mechanisms import drawn_mechanism, modes_of, ratio_of
from lab.plant import Values, values_of
from lab.plant import run as simulate
from mechid.campaign import Campaign
from mechid.campaign.campaign_file import FILE_NAME, TRUTH_NAME
from mechid.campaign.mechanism_text import write_mechanism
from mechid.campaign.templates import MECHANISM_NAME
from mechid.campaign.toml_file import toml_text
from mechid.plant.mechanism import Mechanism
from mechid.writing import write_atomically
from recovery.campaigns import RATE_HZ

HEADER = "SYNTHETIC lab bench: simulated, not measured. The truth is in truth.json."
TRIGGER_S, SCATTER_S = 0.5, 0.02
"""When the command starts in a record: the recorder begins half a second before, by hand or by a relay."""
TRIGGER_SIGMAS = 4.0
"""Bounds of the trigger, in its scatter."""
CLOCK_PPM = (20.0, 50.0)
"""How far the driver's clock is off, either way."""
DECLARED_CLOCK = (
    "clock_ppm = { value = 0.0, min = -200.0, max = 200.0, sigma = 50.0 }  # crystals of both, by data sheet"
)
"""In every second bench; in the others the engineer says whose clock is right, the rest is mechid's."""
SWEEP_S = 40.0
MAY_CLIP = ("full_res", "full_half", "half_res")
QUANTITIES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "torque", "rotor_rate")
UNITS = ("N", "N", "N", "N*m", "N*m", "N*m", "rad/s")
LONGEST_GAP_S = 0.02


@dataclass(frozen=True)
class Run:
    """One test run: its command as a campaign file writes it, and how long the recorder goes on behind its start."""

    command: Mapping[str, Any]
    seconds: float


@dataclass(frozen=True)
class Bench:
    """A bench on disk.

    Attributes
    ----------
    folder : Path
    seed : int
    truth : mapping of str to float
        The free parameters of the mechanism by dotted name, in the file's units.
    own : mapping of str to float
        Those of records and campaign: when each command starts, s; the clock, ppm.
    clipped : str
        Name of the record whose torque was larger than its range.
    """

    folder: Path
    seed: int
    truth: Mapping[str, float]
    own: Mapping[str, float]
    clipped: str


def runs_of(mechanism: Mechanism) -> dict[str, Run]:
    """Return the test runs of a mechanism by name: about the resonance of the load on the gear, and a sweep of 40 s."""
    resonance_hz = math.sqrt(mechanism.value("gear.stiffness") / mechanism.value("load.inertia")) / (2.0 * math.pi)
    rate = round(0.98 * resonance_hz, 1)
    profile = [[0.0, 0.0], [SWEEP_S, round(2.4 * rate, 1)]]
    return {
        "full_res": Run(_command("full", rate=rate), 1.0),
        "full_half": Run(_command("full", rate=round(0.5 * rate, 1)), 1.0),
        "full_slow": Run(_command("full", rate=5.0), 1.5),
        "half_res": Run(_command("half", rate=round(0.7 * rate, 1)), 1.0),
        "micro_res": Run(_command("micro", rate=rate), 1.0),
        "sweep": Run(_command("micro", rate_profile=profile), SWEEP_S),
    }


def _command(stepping: str, **rate: Any) -> dict[str, Any]:
    """Return a command; the mechanism rests where coils and detents balance, as it does before a test."""
    microsteps = {"microsteps": 16} if stepping == "micro" else {}
    return {"stepping": stepping, **microsteps, **rate, "start_angle_deg": 45.0, "start": "equilibrium"}


def make_bench(seed: int, folder: Path, *, sweep_s: float = SWEEP_S) -> Bench:
    """Write the bench of a seed into a folder; truth.json comes last, so that it tells a whole bench.

    `sweep_s` cuts the sweep short, for tests.
    """
    mechanism, truth = drawn_mechanism(seed)
    true = mechanism.with_values(truth)
    runs = runs_of(true)
    runs["sweep"] = replace(runs["sweep"], seconds=sweep_s)
    rng = np.random.default_rng((seed, 1))
    own = {f"record.{name}.time_offset_s": TRIGGER_S + SCATTER_S * _within(rng, 2.5) for name in runs}
    own["campaign.clock_ppm"] = float(rng.choice([-1.0, 1.0])) * rng.uniform(*CLOCK_PPM)
    clipped = str(rng.choice(MAY_CLIP))
    folder.mkdir(parents=True, exist_ok=True)
    write_mechanism(mechanism, folder / MECHANISM_NAME, HEADER)
    values, ranges = values_of(true.value, modes_of(true)), {}
    for (name, run), noise in zip(runs.items(), rng.spawn(len(runs)), strict=True):
        torque, rate = simulated(values, run, own[f"record.{name}.time_offset_s"], own["campaign.clock_ppm"])
        time = np.arange(torque.size) / RATE_HZ
        table = measured(torque, rate, time, ratio_of(mechanism), noise)
        rows, own_ranges = recorded(table, clipped=name == clipped)
        if name == clipped:
            ranges[name] = own_ranges["Mz"]
        rows, header = np.column_stack([time, rows]), ",".join(("time_s", *COLUMNS))
        np.savetxt(folder / f"{name}.csv", rows, fmt="%.8g", delimiter=",", header=header, comments="")
    write_atomically(folder / FILE_NAME, _campaign_text(runs, ranges, clock_declared=seed % 2 == 0))
    told = {"synthetic": True, "seed": seed, "clipped": clipped, "parameters": truth, "own": own}
    write_atomically(folder / TRUTH_NAME, json.dumps(told, indent=1) + "\n")
    return Bench(folder, seed, truth, own, clipped)


def simulated(values: Values, run: Run, delay_s: float, clock_ppm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return torque, N m, and rotor rate, rad/s, of a test run, (N,) each, whose command starts `delay_s` late."""
    times, voltages = edges(run.command, 1.01 * (run.seconds + TRIGGER_S))
    instants = (times + delay_s) / (1.0 + 1e-6 * clock_ppm)
    samples = round((TRIGGER_S + run.seconds) * RATE_HZ) + 1
    found = simulate(values, instants, voltages, math.radians(run.command["start_angle_deg"]), RATE_HZ, samples)
    return found["torque"], found["rotor_rate"]


def near_truth(bench: Bench, campaign: Campaign, share: float) -> dict[str, float]:
    """Return a start for all that is free in a campaign, off by at most a share of each value, within its bounds.

    Phases are off by as much of a radian, instants by as much of the trigger's scatter.
    """
    rng = np.random.default_rng((bench.seed, 2))
    true, start = {**bench.truth, **bench.own}, {}
    for p in campaign.free:
        off = share * rng.uniform(-1.0, 1.0)
        value = true[p.name]
        if p.is_periodic:
            start[p.name] = (value + math.degrees(off) + 180.0) % 360.0 - 180.0
            continue
        step = SCATTER_S if p.name.endswith("time_offset_s") else value
        start[p.name] = min(max(value + off * step, p.min), p.max)
    start["friction.static"] = max(start["friction.static"], start["friction.coulomb"])
    return start


def _within(rng: np.random.Generator, most: float) -> float:
    """Return a draw of the standard normal distribution, cut off at so many sigmas."""
    return float(np.clip(rng.standard_normal(), -most, most))


def _campaign_text(runs: Mapping[str, Run], ranges: Mapping[str, float], *, clock_declared: bool) -> str:
    """Return the campaign file; `ranges` has that of the torque of records that went beyond it, N m."""
    lines = [
        f"# {HEADER}",
        "",
        f'mechanism = "{MECHANISM_NAME}"',
        "synthetic = true",
        'clock_reference = "recorder"',
        *([DECLARED_CLOCK] if clock_declared else []),
    ]
    for name, run in runs.items():
        lines += ["", *_record_lines(name, run, ranges.get(name))]
    lines += ["", "[bench]", 'drive_axis = "z"', f"mounting_point_m = {list(POINT_M)}"]
    lines += ["", "[identify]", f"mains = {round(MAINS_HZ):d}"]
    return "\n".join(lines) + "\n"


def _record_lines(name: str, run: Run, limit: float | None) -> list[str]:
    """Return the lines of a record; the range of its torque is written where it was too small."""
    reach = TRIGGER_SIGMAS * SCATTER_S
    command = ", ".join(f"{key} = {json.dumps(value)}" for key, value in run.command.items())
    columns = zip(QUANTITIES, COLUMNS, UNITS, strict=True)
    conditioning = f"conditioning = {{ limits = {{ torque = [-{limit}, {limit}] }}, max_gap_s = {LONGEST_GAP_S} }}"
    return [
        "[[record]]",
        f"name = {toml_text(name)}",
        f'file = "{name}.csv"',
        f"command = {{ {command} }}",
        f"time_offset_s = {{ value = {TRIGGER_S}, min = {TRIGGER_S - reach:.3g}, max = {TRIGGER_S + reach:.3g}, "
        f"sigma = {SCATTER_S} }}",
        "channels = [",
        *(
            f'  {{ quantity = "{quantity}", column = "{column}", unit = "{unit}" }},'
            for quantity, column, unit in columns
        ),
        "]",
        *([conditioning] if limit else []),
    ]
