"""mechid's entry: the task's catalogue and commands as its files, `identify` without further options."""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from incomplete.stepping import STEPS
from mechid.campaign import load_campaign
from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.campaign.toml_file import toml_text
from mechid.command import Command, RateProfile
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

from ..mechid_benchmark.emission import emission_of

NAME = "mechid"
SUBSTEPS = 8
HEADER = "SYNTHETIC campaign of the public benchmark, as its task sheet gives it"


def enter(folder: Path, work: Path) -> dict[str, Any]:
    """Return the entry of a campaign as a submission holds it; `work` gets the files of mechid."""
    task = json.loads((folder / "task.json").read_text())
    write_files(task, folder, work)
    campaign = load_campaign(work)
    began = time.process_time()
    fit = identify(campaign, workers=1)
    seconds = time.process_time() - began
    return {
        "parameters": {name: _parameter(fit, name) for name in task["asked"]},
        "emission": emission(fit, task),
        "cpu_s": seconds,
        "remark": remark_of(fit),
    }


def remark_of(fit: Fit) -> str:
    """Return grade with its reasons, and missing effects that the fit names."""
    reasons = ", ".join(dict.fromkeys(str(one.cause) for one in fit.reasons))
    missing = ", ".join(one.name for one in fit.missing)
    parts = [f"grade {fit.grade}", f"({reasons})" if reasons else "", f"missing: {missing}" if missing else ""]
    return " ".join(part for part in parts if part)


def _parameter(fit: Fit, name: str) -> dict[str, Any]:
    found = fit.parameters[name]
    interval = found.ci95
    return {"value": found.value} | ({"interval": list(interval)} if interval else {})


def write_files(task: Mapping[str, Any], folder: Path, work: Path) -> None:
    """Write mechanism.toml and campaign.toml of a task into `work`; the records stay where they are."""
    work.mkdir(parents=True, exist_ok=True)
    (work / MECHANISM_NAME).write_text(_mechanism_text(task), encoding="utf-8")
    drafts = [
        RecordDraft(name=name, file=str((folder / one["file"]).resolve()), command=_toml(one["command"]))
        for name, one in task["records"].items()
    ]
    named = f"mechanism = {toml_text(MECHANISM_NAME)}"
    text = campaign_text(drafts, HEADER).replace(named, f'{named}\nsynthetic = true\nclock_reference = "driver"')
    (work / FILE_NAME).write_text(text, encoding="utf-8")


def _mechanism_text(task: Mapping[str, Any]) -> str:
    """Return the mechanism file: known values as numbers, asked ones with catalogue value and bounds."""
    values = {name: f"{value!r}" for name, value in task["known"].items()} | {
        name: f"{{ value = {a['catalogue']!r}, min = {a['min']!r}, max = {a['max']!r} }}"
        for name, a in task["asked"].items()
    }
    heads: dict[str, list[str]] = {}
    for name, text in values.items():
        table, _, key = name.rpartition(".")
        heads.setdefault(table, []).append(f"{key} = {text}")
    # Entries of a list stand behind the table that owns them.
    ordered = sorted(heads, key=lambda table: (table.split(".")[0], table.count("."), table))
    lines = [f"# {HEADER}"]
    for table in ordered:
        parts = table.split(".")
        lines += ["", f"[[{'.'.join(parts[:-1])}]]" if parts[-1].isdigit() else f"[{table}]", *heads[table]]
    return "\n".join(lines) + "\n"


def _toml(command: Mapping[str, Any]) -> str:
    """Return a command as a campaign file writes it; JSON writes texts, numbers and lists alike."""
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in command.items()) + " }"


def emission(fit: Fit, task: Mapping[str, Any]) -> dict[str, Any]:
    """Return the emission of the held-out runs by the fitted mechanism on its test stand, added terms included."""
    found = {}
    for name, one in task["held_out"].items():
        torque = torque_of(fit.mechanism, one["command"], one["seconds"], task["sample_rate_Hz"])
        found[name] = emission_of(torque, one["command"]["rate"])
    return found


def torque_of(mechanism: Mechanism, command: Mapping[str, Any], seconds: float, rate_hz: float) -> Any:
    """Return the torque of a run at a constant rate, (N,) N m."""
    asked = Command(
        stepping=command["stepping"],
        microsteps=STEPS.get(command["stepping"]) or command["microsteps"],
        rate=RateProfile.constant(command["rate"]),
        start_angle_deg=command["start_angle_deg"],
    )
    simulator = Simulator(mechanism.plant, asked, TimeBase(rate_hz, round(seconds * rate_hz) + 1))
    return simulate_run(simulator.run(mechanism.kernel_values(), substeps=SUBSTEPS)).torque
