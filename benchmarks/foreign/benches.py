"""The files of a bench: mechanism.toml of the catalogue, campaign.toml, a CSV a record, truth.json."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foreign.values import TRUTH
from mechid.campaign import catalogue_mechanism
from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.mechanism_text import write_mechanism
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.writing import atomic_file, write_atomically

Command = Mapping[str, Any]
RATE_HZ, NOISE_NM = 10_000.0, 2e-3
TRUTH_NAME = "truth.json"
HEADER = "SYNTHETIC bench, made by {maker}: nothing was measured. What made the records is in truth.json."
_FULL: Command = {"stepping": "full", "start_angle_deg": 45.0}
_MICRO: Command = {"stepping": "micro", "microsteps": 16}
RUNS: Mapping[str, tuple[Command, float]] = {
    "full_46": ({**_FULL, "rate": 46.0}, 1.0),
    "full_23": ({**_FULL, "rate": 23.0}, 1.0),
    "full_5": ({**_FULL, "rate": 5.0}, 1.0),
    "half_32": ({**_FULL, "stepping": "half", "rate": 32.0}, 1.0),
    "micro_46": ({**_MICRO, "rate": 46.0}, 1.0),
    "micro_92": ({**_MICRO, "rate": 92.0}, 1.0),
    "sweep": ({**_MICRO, "rate_profile": [[0.0, 0.0], [8.0, 110.0]]}, 8.0),
}
"""Command as a campaign file writes it, and seconds: at, below and about the load's resonance on the gear (46.9 Hz)."""


Maker = Callable[[Command, float], np.ndarray]
"""From a command and its seconds to the torque, a sample every 1/RATE_HZ s, N m, without noise."""


def make_bench(folder: Path, maker: str, version: str, make: Maker, facts: Mapping[str, Any], seed: int) -> None:
    """Write a bench; records that are there already stay, and truth.json comes last, so that it tells a whole bench.

    Parameters
    ----------
    folder : Path
    maker, version : str
        The simulator.
    make : callable
    facts : mapping
        What else of the truth is to be known.
    seed : int
        Of the noise; each record has a stream of its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    header = HEADER.format(maker=f"{maker} {version}")
    write_mechanism(catalogue_mechanism(), folder / MECHANISM_NAME, header)
    drafts = [RecordDraft(name=name, file=f"{name}.csv", command=_toml(command)) for name, (command, _) in RUNS.items()]
    write_atomically(folder / FILE_NAME, campaign_text(drafts, header))
    generators = np.random.default_rng(seed).spawn(len(RUNS))
    for (name, (command, seconds)), rng in zip(RUNS.items(), generators, strict=True):
        path = folder / f"{name}.csv"
        if path.exists():
            continue
        torque = make(command, seconds)
        noisy = torque + NOISE_NM * rng.standard_normal(torque.size)
        rows = np.stack([np.arange(torque.size) / RATE_HZ, noisy, torque], axis=1)
        with atomic_file(path) as beside:
            np.savetxt(beside, rows, fmt="%.10g", delimiter=",", header="time_s,torque_Nm,without_noise", comments="")
        print(f"{name}: {torque.size} samples, {torque.std():.4g} N m RMS", flush=True)
    told = {
        "synthetic": True,
        "simulator": f"{maker} {version}",
        "noise_Nm": NOISE_NM,
        "seed": seed,
        "parameters": dict(TRUTH),
        **facts,
    }
    write_atomically(folder / TRUTH_NAME, json.dumps(told, indent=1) + "\n")


def _toml(command: Command) -> str:
    """Return a command as a campaign file writes it; JSON writes texts, numbers and lists alike."""
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in command.items()) + " }"
