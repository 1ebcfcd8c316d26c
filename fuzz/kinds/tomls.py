"""The TOML files: campaign, mechanism, structure, budget, fleet, design, made from whole ones with entries changed."""

import math
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from fuzz.draw import Draw
from fuzz.tree import changed, damaged, leaves, plain, toml
from fuzz.trial import Kind, Misread

SEEDS = Path(__file__).parents[1] / "seeds"
RECORD = "time_s,torque_Nm,iA\n" + "".join(f"{k / 1000:.3f},{math.sin(0.3 * k):.6f},{k % 7}\n" for k in range(200))
CAMPAIGN_EXTRAS: tuple[dict[str, Any], ...] = (
    {"sample_rate_hz": 1000.0, "channels": [{"quantity": "torque", "column": "torque", "unit": "N*m", "gain": -1.0}]},
    {"conditioning": {"window_s": [0.0, 0.1], "max_gap_s": 0.002, "limits": {"torque": [-5.0, 5.0]}}},
    {"conditioning": {"quiet_s": {"torque": [[0.0, 0.02]]}, "decimate": 2, "time_stamps": "regular"}},
    {"time_offset_s": {"value": 0.0, "min": -0.002, "max": 0.002}, "offset": False, "drift": True},
    {"peak_voltage": {"value": 5.7, "min": 5.0, "max": 6.0}},
    {"test_stand": {"transducer": {"gain": 1.0}}},
    {"start_state": "estimated"},
    {"burn_in_s": 0.05},
    {"stretch_s": 0.1},
    {"time": {"column": "time", "unit": "s"}, "external_files": ["x.bin"]},
    {
        "channels": [
            {"quantity": "torque", "column": 1},
            {"quantity": "current_phase_a", "column": "iA", "unit": "mA", "use": "validate"},
        ]
    },
    {"command": {"stepping": "half", "rate_profile": [[0.0, 0.0], [0.1, 20.0], [0.2, -20.0]]}},
    {"command": {"stepping": "micro", "microsteps": 16, "rate_table": "rate.csv", "waveform": "square"}},
)
TOPS: tuple[dict[str, Any], ...] = (
    {},
    {},
    {
        "identify": {
            "priors": "fit",
            "colour": "auto",
            "spikes": "reject",
            "disturbances": ["clock", "mains"],
            "mains": 50.0,
        }
    },
    {"clock_ppm": {"value": 0.0, "min": -100.0, "max": 100.0}},
    {"identify": {"max_correlation": 0.99}},
    {"stage": [{"records": ["full_46"], "window_s": [0.0, 0.1], "free": ["gear.stiffness"]}]},
    {"diagnose": {"consider": ["stepper.detent:0.9deg", "clock"]}},
    {"bench": {"drive_axis": "z", "mounting_point_m": [0.0, 0.0, 0.1]}},
)


@cache
def mechanisms() -> tuple[dict[str, Any], ...]:
    """Return whole mechanism files: the paper's, each law of the library, each assembly."""
    from layouts import BRUSHED_DC, LAYOUTS, SINGLE_STEPPER, paper_table
    from layouts import changed as put_over

    paper = tomllib.loads((SEEDS / "mechanism.toml").read_text())
    laws = [put_over(paper_table(), changes) for changes in LAYOUTS.values()]
    friction = {"static": 0.01, "coulomb": 0.005, "viscous": 1e-3}
    others = [
        {"assembly": "current_driven_stepper", **SINGLE_STEPPER},
        {"assembly": "brushed_dc_drive", **BRUSHED_DC, "spring": {"stiffness": 0.05, "rest_angle": 0.2}},
        {"assembly": "direct_torque_drive", "load": {"inertia": 1e-3}, "friction": friction, "drive": {"offset": 0.1}},
        {"assembly": "direct_force_drive", "load": {"mass": 95.0}, "friction": friction, "drive": {"offset": -3.0}},
    ]
    return (paper, paper, *laws, *others)


def write_mechanism(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a mechanism file."""
    tree = changed(draw, draw.choice(mechanisms()))
    content = damaged(draw, toml(tree))
    (folder / "mechanism.toml").write_bytes(content)
    return {"tree": plain(tree) if content == toml(tree).encode("utf-8", "replace") else {}}


def load_mechanism(folder: Path, written: dict[str, Any]) -> None:
    """Read it, compare every number, write it and read it once more."""
    from mechid.campaign import mechanism_text
    from mechid.campaign.mechanism_file import load_mechanism, mechanism_from_table, mechanism_warnings

    mechanism = load_mechanism(folder / "mechanism.toml")
    mechanism_warnings(mechanism, "mechanism.toml")
    for at, value in leaves(written["tree"]):
        name = ".".join(map(str, at))
        if name in mechanism.parameters:
            _compare(mechanism.parameters[name], value, name)
    text = mechanism_text(mechanism)
    again = mechanism_from_table(tomllib.loads(text), "mechanism.toml", folder)
    for name, parameter in mechanism.parameters.items():
        other = again.parameters[name]
        if (other.value, other.min, other.max, other.status) != (
            parameter.value,
            parameter.min,
            parameter.max,
            parameter.status,
        ):
            raise Misread(f"written mechanism: {name} = {parameter.value!r} was {other.value!r} when read again")


def _compare(parameter: Any, entry: Any, name: str) -> None:
    """Compare a parameter with its entry in the file."""
    told = entry if isinstance(entry, dict) else {"value": entry}
    for key, value in told.items():
        found = getattr(parameter, key, None)
        if isinstance(value, bool) or not isinstance(value, int | float) or found != float(value):
            raise Misread(f"parameter {key}: {name} is {found!r} where {value!r} was written")


def write_campaign(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a campaign with its mechanism and records; one of its tables is changed."""
    (folder / "mechanism.toml").write_text((SEEDS / "mechanism.toml").read_text())
    (folder / "full_46.csv").write_text(RECORD)
    (folder / "sweep.csv").write_text(RECORD)
    (folder / "rate.csv").write_text("time_s,rate\n0,0\n0.1,20\n")
    first = {
        "name": "full_46",
        "file": "full_46.csv",
        "command": {"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0},
    }
    second = {
        "name": "sweep",
        "file": "sweep.csv",
        "use": "validate",
        "command": {"stepping": "micro", "microsteps": 16, "rate_profile": [[0.0, 0.0], [1.0, 20.0]]},
    }
    for extra in draw.sample(CAMPAIGN_EXTRAS, draw.choice((0, 1, 1, 2))):
        draw.choice((first, second)).update(extra)
    tree = changed(draw, {"mechanism": "mechanism.toml", **draw.choice(TOPS), "record": [first, second]})
    content = damaged(draw, toml(tree))
    (folder / "campaign.toml").write_bytes(content)
    return {"tree": plain(tree) if content == toml(tree).encode("utf-8", "replace") else {}, "files": draw.chance(0.8)}


def read_campaign(folder: Path, written: dict[str, Any]) -> None:
    """Load it, and compare what it says of each record."""
    from mechid.campaign import load_campaign

    campaign = load_campaign(folder / "campaign.toml", read_records=written["files"])
    entries = {one.get("name"): one for one in written["tree"].get("record", ()) if isinstance(one, dict)}
    for record in campaign.records:
        entry = entries.get(record.name, {})
        if "stretch_s" in entry:
            continue
        command, rate = entry.get("command", {}), entry.get("sample_rate_hz")
        _equal("rate", record.spec.sample_rate_hz, rate, rate is None)
        _equal("start angle", record.command.start_angle_deg, command.get("start_angle_deg", 0.0), not command)
        _equal("use", record.use, entry.get("use", "estimate"), not entry)
        if "rate" in command:
            found = record.command.rate
            _equal(
                "commanded rate",
                float(found.at(0.0)) if hasattr(found, "at") else command["rate"],
                float(command["rate"]),
            )
        _compare_if_number(record.time_offset, entry.get("time_offset_s"))


def _compare_if_number(parameter: Any, entry: Any) -> None:
    if entry is not None:
        _compare(parameter, entry, parameter.name)


def _equal(what: str, found: Any, expected: Any, unsaid: bool = False) -> None:
    if not unsaid and found != expected:
        raise Misread(f"{what}: {found!r} where {expected!r} was written")


def write_budget(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a budget file, or the structure file that it names."""
    from mechid.budgets.example import BUDGET, STRUCTURE

    trees = {"budget.toml": tomllib.loads(BUDGET), "structure.toml": tomllib.loads(STRUCTURE)}
    if draw.chance(0.3):
        trees["structure.toml"]["mode"][1]["directions"] = {"tx": 0.2, "ry": 0.1}
    at = draw.choice(("budget.toml", "budget.toml", "structure.toml"))
    trees[at] = changed(draw, trees[at])
    is_whole = True
    for name, tree in trees.items():
        content = damaged(draw, toml(tree), 0.05)
        is_whole &= content == toml(tree).encode("utf-8", "replace")
        (folder / name).write_bytes(content)
    return {"structure": plain(trees["structure.toml"]) if is_whole else {}}


def read_budget(folder: Path, written: dict[str, Any]) -> None:
    """Read both, and compare the modes."""
    import numpy as np

    from mechid.budgets.budget_file import read_budget_file
    from mechid.structure import read_structure

    structure = read_structure(folder / "structure.toml", axis="rz")
    finite(structure)
    modes = written["structure"].get("mode", [])
    if modes:
        for key, found in (
            ("frequency_hz", structure.model.frequency_hz),
            ("interface", structure.model.interface),
            ("damping", structure.model.damping),
        ):
            expected = [mode[key] for mode in modes]
            if not np.array_equal(np.asarray(found), np.array(expected, dtype=float)):
                raise Misread(f"mode {key}: {found} where {expected} was written")
    read_budget_file(folder / "budget.toml")


def finite(structure: Any) -> None:
    """Refuse responses that are not finite, at some frequencies."""
    import numpy as np

    model = structure.model
    grid = getattr(model, "frequency_hz", np.array([1.0]))
    some = np.array([0.5177, 1.0331, 10.217, 77.713]) if not hasattr(model, "values") else np.asarray(grid)[:3]
    with np.errstate(all="ignore"):
        response = model.response(some) if hasattr(model, "response") else np.zeros(1)
    lines = np.asarray(response)[..., 1:] if np.ndim(response) > 1 else np.asarray(response)
    if not np.all(np.isfinite(lines)):
        raise Misread(f"response not finite: at {some} Hz")


def write_fleet(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a fleet file and the folders that it names."""
    for name in ("FM1", "FM2", "FM3"):
        (folder / name).mkdir()
        (folder / name / "campaign.toml").write_text((SEEDS / "campaign.toml").read_text())
    import datetime

    states = ["before vibration", "after vibration"]
    campaigns = [
        {"folder": "FM1", "label": "a", "unit": "u1", "state": states[0], "covariates": {"temperature_degC": 20.0}},
        {"folder": "FM2", "unit": "u1", "state": states[1], "covariates": {"temperature_degC": -5}},
        {"folder": "FM3", "group": "g", "covariates": {"date": datetime.date(2026, 3, 1)}},
    ]
    tree = changed(draw, {"false_discovery_rate": 0.05, "before_after": [states], "campaign": campaigns})
    (folder / "fleet.toml").write_bytes(damaged(draw, toml(tree)))
    return {}


def read_fleet(folder: Path, written: dict[str, Any]) -> None:
    """Read it, with its folders."""
    from mechid.fleets.fleet_file import read_members

    members = read_members([folder])
    if not 0.0 < members.false_discovery_rate < 1.0:
        raise Misread(f"rate: {members.false_discovery_rate}")


def write_design(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a design file."""
    whole = {
        "seed": 0,
        "recording": {"noise_Nm": 0.002, "sample_rate_hz": 1e4, "duration_s": 1.0, "durations_s": {"full_46": 2.0}},
        "candidates": {
            "steppings": ["full", "micro"],
            "microsteps": 16,
            "rates": [23.0, 46.0],
            "start_angles_deg": [0.0],
            "durations_s": [1.0, 2.0],
            "sweeps_s": [10.0],
            "sweep_to": 120.0,
        },
        "limits": {
            "total_s": 60.0,
            "between_s": 10.0,
            "torque_Nm": 2.0,
            "most_of_one": 2,
            "keep": ["full_46"],
            "risk": 0.2,
        },
        "criterion": {"kind": "D", "over": "mean"},
        "prior": {"mechanisms": 4},
    }
    (folder / "design.toml").write_bytes(damaged(draw, toml(changed(draw, whole))))
    return {}


def read_design(folder: Path, written: dict[str, Any]) -> None:
    """Read it."""
    from mechid.designs.design_file import options_for

    options_for(folder / "campaign.toml")


TOMLS = (
    Kind("mechanism", write_mechanism, load_mechanism, weight=8),
    Kind("campaign", write_campaign, read_campaign, codes=(3, 4), weight=10),
    Kind("budget", write_budget, read_budget, weight=4),
    Kind("fleet", write_fleet, read_fleet, codes=(2, 3), weight=2),
    Kind("design", write_design, read_design, weight=2),
)
