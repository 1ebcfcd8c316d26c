"""Time and peak memory at the sizes that mechid is meant for: an hour of record, many records, many parameters.

    python benchmarks/scale.py hour [--seconds 3600] [--format csv npy] [--commands check simulate] [--folder DIR]
    python benchmarks/scale.py records [--count 500] [--commands check identify] [--folder DIR]
    python benchmarks/scale.py parameters [--folder DIR]

`hour` is the record of `long_records.py` in other formats. `records` are so many of 0.2 s, in steps and rates that all
differ, from the true values, in one stage of two parameters. `parameters` has 60 free ones, of which 30 change no
sample. Every command is a process of its own: its peak is VmHWM, its time CPU seconds; what it reads with is a child,
whose CPU time is counted and whose memory is not.
"""

import argparse
import copy
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from long_records import MEASURED, WRITERS, made, measured_in_a_process
from mechid.campaign import mechanism_text
from mechid.campaign.bench import NOISE_NM, SAMPLE_RATE_HZ, TRUTH, true_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.templates import RecordDraft, campaign_text
from mechid.campaign.trajectory_file import record_rows
from mechid.command import Command, RateProfile
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.writing import write_atomically

SHORT_S = 0.2
TWO = ("gear.stiffness", "gear.damping")
SEEN_DETENTS, UNSEEN_PHASES = 8, 30


def main() -> None:
    """Make what is asked, run the commands, print a row for each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("hour", "records", "parameters"))
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--format", nargs="*", default=["csv", "npy"], choices=("csv", "npy"))
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--commands", nargs="*", default=["check", "identify"])
    parser.add_argument("--folder", type=Path, help="where the campaigns are kept; else a temporary one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        for name, campaign in _campaigns(arguments, folder):
            for command in arguments.commands:
                row = run(campaign, command)
                size, took = f"{row['peak'] / 1e6:.0f} MB", f"{row['cpu_s']:.1f} s"
                print(f"| {name} | {command} | {size} | {took} | exit {row['exit']:.0f} |", flush=True)


def run(campaign: Path, command: str) -> dict[str, float]:
    """Run a command on a campaign; its peak in bytes, CPU seconds and exit code."""
    out = {"identify": ["--out", campaign / "result"], "simulate": ["--out", campaign / "simulated"]}
    of = campaign / "result" if command == "report" else campaign
    peak, cpu, code, *_ = measured_in_a_process(MEASURED, [command, of, *out.get(command, [])])
    return {"peak": peak, "cpu_s": cpu, "exit": code}


def _campaigns(arguments: argparse.Namespace, folder: Path) -> Iterator[tuple[str, Path]]:
    if arguments.what == "records":
        yield f"{arguments.count} records", many_records(folder / f"{arguments.count}", arguments.count)
    elif arguments.what == "parameters":
        yield "60 parameters", many_parameters(folder / "parameters")
    else:
        for kind in arguments.format:
            yield f"{arguments.seconds:g} s, {kind}", in_format(folder, arguments.seconds, kind)


def in_format(folder: Path, seconds: float, kind: str) -> Path:
    """Return the campaign of a long record whose file has another format."""
    source = made(folder / f"{seconds:g}", seconds)
    campaign = folder / f"{seconds:g}-{kind}"
    campaign.mkdir(exist_ok=True)
    if not (campaign / f"run.{kind}").exists():
        write = next(write for suffix, write in WRITERS.values() if suffix == kind)
        write(source, campaign / f"run.{kind}")
    for name in ("rate.csv", "mechanism.toml"):
        write_atomically(campaign / name, (source / name).read_text())
    rate = "sample_rate_hz = 10000.0\n" if kind == "npy" else ""
    text = f'mechanism = "mechanism.toml"\n\n[[record]]\nname = "run"\nfile = "run.{kind}"\n{rate}'
    text += 'command = { stepping = "micro", microsteps = 16, rate_table = "rate.csv" }\n'
    write_atomically(campaign / "campaign.toml", text)
    return campaign


def many_records(folder: Path, count: int) -> Path:
    """Write a campaign of many short records, one stage of two parameters that start 2 % off."""
    folder.mkdir(parents=True, exist_ok=True)
    truth, rng = true_mechanism(), np.random.default_rng(18)
    drafts = []
    for k in range(count):
        steps, rate = (1, 16)[k % 2], round(10.0 + 110.0 * k / count, 3)
        name = f"run_{k:03d}"
        _write_record(folder / f"{name}.csv", truth, _command(steps, rate), SHORT_S, rng)
        drafts.append(RecordDraft(name=name, file=f"{name}.csv", command=_command_text(steps, rate)))
    start = truth.with_free(TWO).with_values({name: 1.02 * truth.value(name) for name in TWO})
    stage = f"\n[[stage]]\nrecords = {[draft.name for draft in drafts]}\nfree = {list(TWO)}\n".replace("'", '"')
    write_atomically(folder / "mechanism.toml", mechanism_text(start, "SYNTHETIC"))
    write_atomically(folder / "campaign.toml", campaign_text(drafts, "SYNTHETIC") + stage)
    return folder


def many_parameters(folder: Path) -> Path:
    """Write a campaign with 60 free parameters; 30 are phases of harmonics that have no amplitude.

    Of the 30 others two are a detent of a period that is there already: only its sum with that one is seen.
    """
    folder.mkdir(parents=True, exist_ok=True)
    table = copy.deepcopy(dict(CATALOGUE))
    table["stepper"]["detent"] += [_seen(k) for k in range(3, 3 + SEEN_DETENTS)]
    table["stepper"]["detent"] += [_unseen(k) for k in range(20, 20 + UNSEEN_PHASES)]
    table["gear"]["damping"] = 0.39
    mechanism = mechanism_from_table(table, "catalogue")
    truth = mechanism.with_values({name: value for name, value in TRUTH.items() if name != "gear.damping"})
    rng = np.random.default_rng(19)
    drafts = []
    for steps, rate in ((1, 46.0), (1, 23.0), (16, 46.0), (16, 92.0)):
        name = f"{'full' if steps == 1 else 'micro'}_{rate:g}"
        _write_record(folder / f"{name}.csv", truth, _command(steps, rate), 1.0, rng)
        drafts.append(RecordDraft(name=name, file=f"{name}.csv", command=_command_text(steps, rate)))
    write_atomically(folder / "mechanism.toml", mechanism_text(truth, "SYNTHETIC, from the true values"))
    write_atomically(folder / "campaign.toml", campaign_text(drafts, "SYNTHETIC"))
    return folder


def _seen(k: int) -> dict[str, Any]:
    """Return a detent of k periods in a turn of the rotor's two full steps, of a size that records show."""
    return {
        "period_deg": 7.2 / k,
        "amplitude": {"value": 0.002, "min": 0.0, "max": 0.05},
        "phase_deg": {"value": 20.0 * k, "min": -180.0, "max": 180.0},
    }


def _unseen(k: int) -> dict[str, Any]:
    return {"period_deg": 7.2 / k, "amplitude": 0.0, "phase_deg": {"value": 0.0, "min": -180.0, "max": 180.0}}


def _command(steps: int, rate: float) -> Command:
    stepping = "full" if steps == 1 else "micro"
    return Command(stepping=stepping, microsteps=steps, rate=RateProfile.constant(rate), start_angle_deg=45.0)


def _command_text(steps: int, rate: float) -> str:
    own = '"full"' if steps == 1 else f'"micro", microsteps = {steps}'
    return f"{{ stepping = {own}, rate = {rate}, start_angle_deg = 45.0 }}"


def _write_record(path: Path, truth: Mechanism, command: Command, seconds: float, rng: np.random.Generator) -> None:
    if path.exists():
        return
    base = TimeBase(SAMPLE_RATE_HZ, round(seconds * SAMPLE_RATE_HZ) + 1)
    torque = simulate_run(Simulator(truth.plant, command, base).run(truth.kernel_values(), substeps=2)).torque
    torque = torque + NOISE_NM * rng.standard_normal(torque.size)
    time = np.arange(torque.size) / SAMPLE_RATE_HZ
    write_atomically(path, record_rows(time, torque, time_format="%.4f", torque_format="%.6e"))


if __name__ == "__main__":
    main()
