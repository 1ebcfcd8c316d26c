"""A mechanism of the recovery benchmark with its six records, as files."""

import json
from pathlib import Path

import numpy as np

from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.mechanism_text import write_mechanism
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.campaign.trajectory_file import record_rows
from mechid.command import Command
from mechid.writing import write_atomically
from recovery.campaigns import campaign, runs_of
from recovery.mechanisms import FAMILIES

COMMENT = "SYNTHETIC: simulated from a mechanism of the recovery benchmark; nothing here was measured."


def write_recovery_bench(folder: Path, family: int, seed: int) -> None:
    """Write campaign, catalogue and records of a seed: the samples that `make recovery` identifies from."""
    catalogue, truth = FAMILIES[family].catalogue(), FAMILIES[family].truth(seed)
    folder.mkdir(parents=True, exist_ok=True)
    write_mechanism(catalogue, folder / MECHANISM_NAME, COMMENT)
    commands = {name: test.command for name, test in runs_of(truth).items()}
    drafts = [RecordDraft(name=n, file=f"{n}.csv", command=_toml(c)) for n, c in commands.items()]
    write_atomically(folder / FILE_NAME, campaign_text(drafts, COMMENT))
    for record in campaign(catalogue, truth, seed, "all").records:
        data = record.data
        rows = record_rows(
            np.arange(data.samples) / data.sample_rate_hz,
            data.channels[0].data,
            time_format="%.6f",
            torque_format="%.9e",
        )
        write_atomically(folder / record.file, rows)


def _toml(command: Command) -> str:
    """Return a command as the campaign file writes it."""
    rate = command.rate
    points = [[float(t), float(v)] for t, v in zip(rate.times_s, rate.rates, strict=True)]
    speed = f"rate = {points[0][1]!r}" if len(points) == 1 else f"rate_profile = {json.dumps(points)}"
    stepping = f'stepping = "{command.stepping}"'
    if command.stepping == "micro":
        stepping += f", microsteps = {command.microsteps}"
    return f"{{ {stepping}, {speed}, start_angle_deg = {command.start_angle_deg!r} }}"
