"""A small campaign, commands of it, and what they give where nobody disturbs them."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from mechid.budgets.example import BUDGET, STRUCTURE
from mechid.campaign.bench import write_bench

RECORDS = ("full_46", "micro_46")
SHORT_S = 0.3
NOT_NUMBERS = {
    "seconds",
    "wall_time_s",
    "elapsed_s",
    "time",
    "took_s",
    "inputs_sha256",
    "folder",
    "source",
    "how",
    "how_words",
    "words",
}
"""Keys of result files that differ from run to run, or from folder to folder."""
RESULTS = {
    "identify": "estimate.json",
    "bootstrap": "bootstrap.json",
    "profile": "profile.json",
    "budget": "budget.json",
    "fleet": "fleet.json",
}
WAIT_S = 900.0


@dataclass(frozen=True)
class Trial:
    """One disturbance; `run` returns ``faults``, a list of what was not as promised, and what was measured."""

    number: int
    what: str
    run: Callable[[], Mapping[str, object]]


class Reference:
    """The campaign and what its commands give, made once in a folder and kept there."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.seed = folder.resolve(), seed
        self.folder.mkdir(parents=True, exist_ok=True)

    @cached_property
    def bench(self) -> Path:
        """Folder of a campaign of two short records, the catalogue its start."""
        place = self.folder / "bench"
        if not place.exists():
            made = self.folder / "bench.being_made"
            shutil.rmtree(made, ignore_errors=True)
            write_bench(made, self.seed, sweep_s=1.0)
            text = (made / "campaign.toml").read_text()
            head, *records = text.split("[[record]]")
            kept = [record for record in records if any(f'"{name}"' in record for name in RECORDS)]
            (made / "campaign.toml").write_text("[[record]]".join([head, *kept]))
            for name in RECORDS:
                rows = (made / f"{name}.csv").read_text().splitlines()
                short = [row for row in rows[1:] if float(row.split(",")[0]) <= SHORT_S]
                (made / f"{name}.csv").write_text("\n".join([rows[0], *short]) + "\n")
            made.rename(place)
        return place

    @cached_property
    def fit(self) -> Path:
        """Result folder of the undisturbed identification, with a budget file."""
        place = self.folder / "identify"
        if not (place / "budget.toml").exists():
            done = run([*self.command("identify", place)])
            assert (place / "estimate.json").exists(), done.stderr
            one_rate = re.sub(r"duty = .*\n", "", BUDGET)
            one_rate = one_rate[: one_rate.index('[[mode]]\nname = "slew"')] + BUDGET[BUDGET.index("[[requirement]]") :]
            one_rate = one_rate.replace("rate_range = { from = 10.0, to = 60.0, count = 26 }", "rates = [20.0, 47.5]")
            (place / "structure.toml").write_text(STRUCTURE)
            (place / "budget.toml").write_text(one_rate)
        return place

    def command(self, verb: str, out: Path) -> list[str]:
        """Return a command line into a folder, which takes up what is there."""
        asked = {
            "identify": lambda: ["--resume", self.bench],
            "bootstrap": lambda: ["--resume", self.fit, "--draws", 6],
            "profile": lambda: ["--resume", self.fit, "--parameter", "gear.stiffness"],
            "budget": lambda: [self.fit / "budget.toml"],
            "fleet": lambda: [self.bench],
        }[verb]
        return [sys.executable, "-m", "mechid", verb, *map(str, asked()), "--out", str(out)]

    def whole(self, verb: str) -> tuple[object, float]:
        """Return the numbers of the undisturbed run, and how long it takes, s."""
        place, timed = self.folder / verb, self.folder / f"{verb}.seconds"
        if verb == "identify":
            assert self.fit
        if not timed.exists():
            out = self.folder / "timed"
            shutil.rmtree(out, ignore_errors=True)
            began = time.perf_counter()
            run(self.command(verb, out))
            took = time.perf_counter() - began
            if verb != "identify":
                shutil.rmtree(place, ignore_errors=True)
                out.rename(place)
            timed.write_text(str(took))
        return numbers(place, verb), float(timed.read_text())

    def empty(self, name: str) -> Path:
        """Return a folder for a trial, which is not there yet."""
        place = self.folder / "trials" / name
        shutil.rmtree(place, ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        return place


def run(command, **environment) -> subprocess.CompletedProcess:
    """Run a command to its end."""
    return subprocess.run(
        command, capture_output=True, text=True, timeout=WAIT_S, env=os.environ | environment, check=False
    )


def numbers(folder: Path, verb: str) -> object:
    """Return the result of a command without what differs from run to run."""
    return _without(json.loads((folder / RESULTS[verb]).read_text()))


def _without(value):
    if isinstance(value, dict):
        return {key: _without(entry) for key, entry in value.items() if key not in NOT_NUMBERS}
    return [_without(entry) for entry in value] if isinstance(value, list) else value


def afterwards(reference: Reference, verb: str, out: Path, *, ends=(0, 5)) -> list[str]:
    """Run a command again, undisturbed, and return what is not as if nobody had disturbed it."""
    faults = half_written(out)
    done = run(reference.command(verb, out))
    if done.returncode not in ends:
        return [*faults, f"afterwards: exit code {done.returncode}: {last(done.stderr)}"]
    faults += unexpected(done.stderr)
    if numbers(out, verb) != reference.whole(verb)[0]:
        faults.append("afterwards: other numbers")
    left = [path.name for path in out.rglob("*") if path.name.endswith((".part", ".lock"))]
    return faults + ([f"left behind: {left}"] if left else [])


def half_written(out: Path) -> list[str]:
    """Return the result files that are there and cannot be read."""
    faults = []
    for path in out.rglob("*.json") if out.exists() else ():
        try:
            json.loads(path.read_text())
        except ValueError:
            faults.append(f"half-written: {path.name}")
    return faults


def unexpected(said: str) -> list[str]:
    """Return what nobody should see."""
    return [f"said: {word}" for word in ("Traceback", "unexpected error") if word in said]


def last(said: str) -> str:
    """Return the last line of what a command said."""
    return (said.strip().splitlines() or [""])[-1][:300]
