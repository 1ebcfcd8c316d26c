"""Synthetic bench: records simulated from the paper's estimates, with noise, and the true values.

The mechanism's values are those that [Kornienko2013]_ identified (Table 1). The peak voltage and the
detent phases are assumed. The records are simulated: none of the data was measured.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import Campaign
from mechid.campaign.campaign_file import FILE_NAME, TRUTH_NAME, load_campaign
from mechid.campaign.catalogue import catalogue_mechanism
from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.prediction import simulate
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.campaign.trajectory_file import record_rows, refuse_incomplete
from mechid.errors import UsageError
from mechid.plant.mechanism import Mechanism
from mechid.writing import creating_folder, write_atomically

TRUTH: Mapping[str, float] = {
    "stepper.coil_resistance": 9.9,
    "stepper.coil_inductance": 0.045,
    "stepper.torque_constant": 0.384,
    "stepper.detent.0.amplitude": 0.0047,
    "stepper.detent.0.phase_deg": 35.0,
    "stepper.detent.1.amplitude": 0.0231,
    "stepper.detent.1.phase_deg": -110.0,
    "friction.static": 0.008,
    "friction.coulomb": 0.0013,
    "friction.viscous": 0.0061,
    "gear.stiffness": 913.47,
    "gear.damping": 0.39,
    "housing.gain": 4.6,
    "housing.frequency": 5578.0,
    "housing.damping": 0.095,
}
"""True values that the identification should recover: the paper's estimates and assumed detent phases."""

SAMPLE_RATE_HZ = 10_000.0
NOISE_NM = 0.002
OFFSET_NM = 0.01
DRIFT_NM = 0.004
"""Standard deviations: noise of each sample; offset and drift over a record, drawn once per record."""

CAMPAIGN_COMMENT = """\
SYNTHETIC: nothing here was measured. The records are simulated from the values in truth.json, with 2 mN m of
white noise, an offset and a drift. mechanism.toml holds a supplier's catalogue, wrong by factors."""
MECHANISM_COMMENT = """\
SYNTHETIC bench: the catalogue values of the mechanism in Kornienko, Wuseni, Specht (IFAC ACA 2013), from
which the identification starts. The peak voltage is assumed. What made the records is in truth.json."""


@dataclass(frozen=True)
class BenchRecord:
    """A record of the bench: its command in the notation of the campaign file, and its duration in s."""

    name: str
    command: str
    duration_s: float = 1.0


def bench_records(sweep_s: float = 60.0) -> tuple[BenchRecord, ...]:
    """Return full-step and microstep records at 23, 46 and 92 steps/s, and a microstep sweep to 120 steps/s."""
    full = '{{ stepping = "full", rate = {:.1f}, start_angle_deg = 45.0 }}'
    micro = '{{ stepping = "micro", microsteps = 16, rate = {:.1f} }}'
    profile = f"[[0.0, 0.0], [{sweep_s:.1f}, {2.0 * sweep_s:.1f}]]"
    sweep = f'{{ stepping = "micro", microsteps = 16, rate_profile = {profile} }}'
    return (
        *(BenchRecord(f"full_{rate}", full.format(rate)) for rate in (23, 46, 92)),
        *(BenchRecord(f"micro_{rate}", micro.format(rate)) for rate in (23, 46, 92)),
        BenchRecord("sweep", sweep, sweep_s),
    )


def true_mechanism() -> Mechanism:
    """Return the mechanism from which the bench's records are simulated."""
    return catalogue_mechanism().with_values(TRUTH)


def refuse_measured_campaign(folder: Path) -> None:
    """Raise UsageError if the folder holds a campaign of measured records, which a bench would overwrite."""
    if (folder / FILE_NAME).exists() and not (folder / TRUTH_NAME).exists():
        raise UsageError(f"{folder}: holds a {FILE_NAME} of measured records; give another folder")


def write_bench(
    folder: Path | str, seed: int = 0, *, sweep_s: float = 60.0, truth: Mapping[str, float] = TRUTH
) -> Path:
    """Write a synthetic campaign: campaign.toml, mechanism.toml, a CSV file per record, truth.json.

    Parameters
    ----------
    folder : Path
        Created with its parents if missing; files of these names are overwritten.
    seed : int
        Seed of the noise, offsets and drifts.
    sweep_s : float
        Duration of the sweep in s; its rate rises from 0 to twice that number in steps/s.
    truth : mapping of str to float
        True values by dotted name, in the file's units; parameters not listed keep their catalogue values.

    Returns
    -------
    Path
        The campaign file.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder, records = Path(folder), bench_records(sweep_s)
    with creating_folder(folder):
        campaign = _write_campaign_files(folder, records, truth)
        # One generator per record: the noise of a record does not depend on the length of the others.
        generators = np.random.default_rng(seed).spawn(len(records))
        for record, rng in zip(records, generators, strict=True):
            _write_record(folder, record, campaign, rng)
    return campaign.path


def _write_campaign_files(folder: Path, records: tuple[BenchRecord, ...], truth: Mapping[str, float]) -> Campaign:
    """Write the campaign's files; return the campaign with the true mechanism."""
    drafts = [RecordDraft(name=r.name, file=f"{r.name}.csv", command=r.command) for r in records]
    write_atomically(folder / MECHANISM_NAME, mechanism_text(catalogue_mechanism(), MECHANISM_COMMENT))
    write_atomically(folder / FILE_NAME, campaign_text(drafts, CAMPAIGN_COMMENT, synthetic=True))
    write_atomically(folder / TRUTH_NAME, json.dumps(dict(truth), indent=1) + "\n")
    return replace(load_campaign(folder, read_records=False), mechanism=catalogue_mechanism().with_values(truth))


def _write_record(folder: Path, record: BenchRecord, campaign: Campaign, rng: np.random.Generator) -> None:
    trajectory = simulate(campaign, record.name, sample_rate_hz=SAMPLE_RATE_HZ, duration_s=record.duration_s)
    refuse_incomplete({record.name: trajectory})
    time = trajectory.time[:]
    torque = trajectory.torque + _disturbance(rng, time)
    rows = record_rows(time, torque, time_format="%.6f", torque_format="%.9e")
    write_atomically(folder / f"{record.name}.csv", rows)


def _disturbance(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Return white noise with an offset and a linear drift, (n,) N m."""
    offset, drift = rng.normal(0.0, (OFFSET_NM, DRIFT_NM))
    noise = rng.normal(0.0, NOISE_NM, time.size)
    return np.asarray(noise + offset + drift * time / time[-1], dtype=np.float64)
