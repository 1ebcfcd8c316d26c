"""A right synthetic campaign, and the files of one in which something is wrong."""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.campaign.bench import TRUTH
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.trajectory_file import record_rows
from mechid.command import Command, RateProfile
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.writing import write_atomically

FloatArray = NDArray[np.float64]
RATE_HZ = 10_000.0
SUBSTEPS = 8
NOISE_NM, OFFSET_NM, DRIFT_NM = 2e-3, 10e-3, 4e-3
SWEEP_S, SWEEP_TO = 12.0, 120.0
HEADER = "time_s,torque_Nm"


@dataclass(frozen=True)
class Run:
    """A test run: how its motor is stepped, at which rate, and how long it takes."""

    microsteps: int
    rate: RateProfile
    seconds: float
    start_angle_deg: float = 0.0

    @property
    def command(self) -> Command:
        """As it is."""
        stepping = "full" if self.microsteps == 1 else "micro"
        return Command(
            stepping=stepping, microsteps=self.microsteps, rate=self.rate, start_angle_deg=self.start_angle_deg
        )

    @property
    def entry(self) -> dict[str, str]:
        """The keys of its command, as TOML writes them."""
        points = ", ".join(f"[{t}, {rate}]" for t, rate in zip(self.rate.times_s, self.rate.rates, strict=True))
        stepping = {"stepping": '"full"'} if self.microsteps == 1 else {"stepping": '"micro"', "microsteps": "16"}
        rate = {"rate": f"{self.rate.rates[0]}"} if len(self.rate.rates) == 1 else {"rate_profile": f"[{points}]"}
        return {**stepping, **rate, "start_angle_deg": f"{self.start_angle_deg}"}


RUNS = {
    "full_46": Run(1, RateProfile.constant(46.0), 1.0, 45.0),
    "full_23": Run(1, RateProfile.constant(23.0), 1.0, 45.0),
    "full_5": Run(1, RateProfile.constant(5.0), 1.5, 45.0),
    "micro_46": Run(16, RateProfile.constant(46.0), 1.0),
    "micro_92": Run(16, RateProfile.constant(92.0), 1.0),
    "sweep": Run(16, RateProfile.through([(0.0, 0.0), (SWEEP_S, SWEEP_TO)]), SWEEP_S),
}


SHORT_S = {"full_46": 0.6, "full_23": 0.6, "full_5": 0.7, "micro_46": 0.6, "micro_92": 0.6, "sweep": 3.0}


def shorten() -> None:
    """Make all runs of this process a third as long, for a fit of each case in a third of the time."""
    for name, seconds in SHORT_S.items():
        RUNS[name] = replace(RUNS[name], seconds=seconds)
    RUNS["sweep"] = replace(RUNS["sweep"], rate=RateProfile.through([(0.0, 0.0), (SHORT_S["sweep"], SWEEP_TO)]))


def time_of(name: str) -> FloatArray:
    """Return the time of a run's samples, (N,) s."""
    return np.asarray(np.arange(round(RUNS[name].seconds * RATE_HZ) + 1) / RATE_HZ)


@cache
def clean_torque(name: str) -> FloatArray:
    """Return the torque of the demo's mechanism in a run, (N,) N m, without noise."""
    run = RUNS[name]
    truth = mechanism_from_table(copy.deepcopy(dict(CATALOGUE)), "catalogue").with_values(TRUTH)
    simulator = Simulator(truth.plant, run.command, TimeBase(RATE_HZ, time_of(name).size))
    return simulate_run(simulator.run(truth.kernel_values(), substeps=SUBSTEPS)).torque


@cache
def measured_torque(name: str) -> FloatArray:
    """Return what a transducer gives in a run, (N,) N m."""
    return as_measured(name, clean_torque(name))


def as_measured(name: str, torque: FloatArray) -> FloatArray:
    """Return what the transducer of a run gives of a torque, (N,) N m: with noise, an offset and a drift."""
    rng = np.random.default_rng((18, [*RUNS].index(name)))
    offset, drift = rng.normal(0.0, (OFFSET_NM, DRIFT_NM))
    ramp = np.linspace(0.0, 1.0, torque.size)
    return np.asarray(torque + NOISE_NM * rng.standard_normal(torque.size) + offset + drift * ramp)


def right_files(folder: Path) -> Path:
    """Write the records of the right campaign, those that are not there yet, and return their folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in RUNS:
        if not (folder / f"{name}.csv").exists():
            write_atomically(folder / f"{name}.csv", csv_text(time_of(name), measured_torque(name)))
    return folder


def csv_text(time: FloatArray, torque: FloatArray) -> str:
    """Return a record as CSV."""
    return "".join(record_rows(time, torque, time_format="%.6f", torque_format="%.9e"))


@dataclass
class Files:
    """A campaign about to be written, right until somebody makes it wrong.

    Attributes
    ----------
    mechanism : dict
        The catalogue, as a mechanism file.
    entries : dict of record to keys of its entry, as TOML writes them
    commands : dict of record to keys of its command, as TOML writes them
    texts : dict of file to its text
        Records that are not as the right ones.
    """

    mechanism: dict[str, Any] = field(default_factory=lambda: copy.deepcopy(dict(CATALOGUE)))
    entries: dict[str, dict[str, str]] = field(default_factory=lambda: {name: {} for name in RUNS})
    commands: dict[str, dict[str, str]] = field(default_factory=lambda: {name: run.entry for name, run in RUNS.items()})
    texts: dict[str, str] = field(default_factory=dict)

    def put(self, name: str, torque: FloatArray, time: FloatArray | None = None) -> None:
        """Give a record other samples, (N,) N m, at other times, (N,) s."""
        self.texts[f"{name}.csv"] = csv_text(time_of(name) if time is None else time, torque)

    def write(self, folder: Path, right: Path, *, from_truth: bool = False) -> Path:
        """Write the campaign; what is right is linked from the folder of right records.

        Where it starts from the truth, what is free has its true value, or the bound next to it.
        """
        folder.mkdir(parents=True, exist_ok=True)
        for name in RUNS:
            path = folder / f"{name}.csv"
            path.unlink(missing_ok=True)
            if path.name in self.texts:
                write_atomically(path, self.texts[path.name])
            else:
                os.link(right / path.name, path)
        mechanism = mechanism_from_table(copy.deepcopy(self.mechanism), "catalogue")
        if from_truth:
            limits = {q.name: q for q in mechanism.free}
            true = {name: min(max(value, limits[name].min), limits[name].max) for name, value in TRUTH.items()}
            mechanism = mechanism.with_values(true)
        write_atomically(folder / "mechanism.toml", mechanism_text(mechanism, "SYNTHETIC"))
        write_atomically(folder / "campaign.toml", 'mechanism = "mechanism.toml"\n' + "".join(map(self._entry, RUNS)))
        return folder

    def _entry(self, name: str) -> str:
        command = ", ".join(f"{key} = {value}" for key, value in self.commands[name].items())
        own = {"name": f'"{name}"', "file": f'"{name}.csv"', **self.entries[name], "command": f"{{ {command} }}"}
        return "\n[[record]]\n" + "".join(f"{key} = {value}\n" for key, value in own.items())
