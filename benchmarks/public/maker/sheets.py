"""Files of a campaign: a CSV of each record, task.json for programs, task.md for people. None holds an answer."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..mechid_benchmark.emission import RATE_HZ, WINDOW_S, emission_of
from ..mechid_benchmark.tasks import CAMPAIGNS, FORMAT, ORDERS, UNITS
from .campaigns import (
    DETENT_PERIODS_DEG,
    GEAR_RATIO,
    HALF_POLES,
    LOAD_INERTIA,
    ROTOR_INERTIA,
    SUPPLY_V,
    TABLE,
    resonance_of,
    rng_of,
    sizes_of,
    truth_of,
    values_of,
)
from .measurement import NOISE_NM, measured
from .runs import Run, held_out_of, runs_of, torque_of

MAY_BE_BAD = ("full_half", "half_res", "micro_res")
KNOWN = {
    "stepper.poles": 2.0 * HALF_POLES,
    "stepper.peak_voltage": SUPPLY_V,
    "stepper.rotor_inertia": ROTOR_INERTIA,
    "stepper.detent.0.period_deg": DETENT_PERIODS_DEG[0],
    "stepper.detent.1.period_deg": DETENT_PERIODS_DEG[1],
    "gear.ratio": GEAR_RATIO,
    "load.inertia": LOAD_INERTIA,
}
CATALOGUE = {
    "stepper.coil_resistance": (9.5, 5.0, 20.0),
    "stepper.coil_inductance": (0.0229, 0.005, 0.1),
    "stepper.torque_constant": (0.277, 0.1, 0.8),
    "stepper.detent.0.amplitude": (0.01, 0.0, 0.1),
    "stepper.detent.0.phase_deg": (0.0, -180.0, 180.0),
    "stepper.detent.1.amplitude": (0.0, 0.0, 0.1),
    "stepper.detent.1.phase_deg": (0.0, -180.0, 180.0),
    "friction.static": (0.03, 0.0, 0.1),
    "friction.coulomb": (0.0265, 0.0, 0.1),
    "friction.viscous": (0.000974, 0.0, 0.05),
    "gear.stiffness": (2200.0, 300.0, 5000.0),
    "gear.damping": (0.48, 0.02, 5.0),
    "housing.gain": (2.0, 0.1, 20.0),
    "housing.frequency": (5000.0, 2500.0, 9000.0),
    "housing.damping": (0.05, 0.005, 0.5),
}
"""Catalogue value, least and largest value of each asked parameter: the supplier's, wrong by factors."""
SHEET = Path(__file__).with_name("sheet.md")


def write_campaign(number: str, folder: Path) -> None:
    """Write a campaign into a folder; task.json comes last, so that it tells a whole campaign. Equal runs, equal files.

    Raises
    ------
    OSError
        A file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    campaign, sizes = TABLE[number], sizes_of(number)
    v, rng = values_of(truth_of(number), sizes), rng_of(number, 2)
    bad = str(rng.choice(MAY_BE_BAD)) if campaign.bad_record else ""
    resonance_hz = resonance_of(number)
    runs = runs_of(resonance_hz)
    for (name, one), own in zip(runs.items(), rng.spawn(len(runs)), strict=True):
        torque = torque_of(v, one)
        y = measured(torque, own, noise=campaign.noise, mains_Nm=sizes.get("mains_Nm", 0.0), loose=name == bad)
        rows = np.stack([np.arange(y.size) / RATE_HZ, y], axis=1)
        np.savetxt(
            folder / f"{name}.csv", rows, fmt=("%.4f", "%.7g"), delimiter=",", header="time_s,torque_Nm", comments=""
        )
    task = task_of(number, runs, held_out_of(resonance_hz))
    (folder / "task.md").write_text(sheet_of(task), encoding="utf-8")
    (folder / "task.json").write_text(json.dumps(task, indent=1) + "\n", encoding="utf-8")


def task_of(number: str, runs: Mapping[str, Run], held_out: Mapping[str, Run]) -> dict[str, Any]:
    """Return the task as task.json holds it."""
    return {
        "campaign": number,
        "synthetic": True,
        "sample_rate_Hz": RATE_HZ,
        "known": KNOWN,
        "asked": {
            name: {"unit": UNITS[name], "catalogue": value, "min": low, "max": high}
            for name, (value, low, high) in CATALOGUE.items()
        },
        "records": {
            name: {"file": f"{name}.csv", "seconds": one.seconds, "command": one.command} for name, one in runs.items()
        },
        "held_out": {name: {"seconds": one.seconds, "command": one.command} for name, one in held_out.items()},
        "emission": {"window_s": WINDOW_S, "orders": ORDERS},
        "submission_format": FORMAT,
    }


def sheet_of(task: Mapping[str, Any]) -> str:
    """Return the task sheet."""
    asked = [
        f"| {n} | {a['unit']} | {a['catalogue']:g} | {a['min']:g} | {a['max']:g} |" for n, a in task["asked"].items()
    ]
    runs = [
        f"| {name} | {one.get('file', 'held out')} | {one['seconds']:g} | {_words(one['command'])} |"
        for name, one in {**task["records"], **task["held_out"]}.items()
    ]
    return SHEET.read_text(encoding="utf-8").format(
        number=task["campaign"],
        rate=f"{RATE_HZ:g}",
        noise=f"{1e3 * NOISE_NM:g}",
        known="\n".join(f"| {name} | {value:g} |" for name, value in task["known"].items()),
        asked="\n".join(asked),
        runs="\n".join(runs),
        window="{:g} to {:g}".format(*WINDOW_S),
        orders=", ".join(f"{order:g}" for order in ORDERS),
        format=FORMAT,
    )


def _words(command: Mapping[str, Any]) -> str:
    stepping = f"micro, {command['microsteps']} a full step" if command["stepping"] == "micro" else command["stepping"]
    if "rate" in command:
        return f"{stepping}; {command['rate']:g} full steps/s"
    (_, first), (end, last) = command["rate_profile"]
    return f"{stepping}; {first:g} to {last:g} full steps/s, linear in {end:g} s"


def answers() -> dict[str, Any]:
    """Return the answers to all campaigns: true values, and the emission of the true mechanism off the bench."""
    found = {}
    for number in CAMPAIGNS:
        truth = truth_of(number)
        v = values_of(truth, sizes_of(number))
        emission = {
            name: emission_of(torque_of(v, one), one.command["rate"])
            for name, one in held_out_of(resonance_of(number)).items()
        }
        found[number] = {"parameters": truth, "emission": emission}
    return found
