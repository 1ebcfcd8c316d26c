"""The records of one mechanism: simulated with margin, with seeded noise, offset and drift, held in memory."""

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import TIME_OFFSET, record_parameter_name
from mechid.command import Command, RateProfile
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.phases import STAR
from mechid.records import Record, RecordSpec
from mechid.records.record import Channel
from mechid.records.spec import Role
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

RATE_HZ = 10_000.0
SUBSTEPS = 8
UNIPOLAR = 4
"""Integration steps a sample of what makes the records, and of what judges the estimates."""
NOISE_NM, OFFSET_NM, DRIFT_NM = 2e-3, 10e-3, 4e-3
"""Standard deviations: of each sample; between records, of the offset and of the drift over a record."""
VARIANTS = {"all": None, "slow": "full_slow", "sweep": "sweep"}
"""Variant -> the record that is left out."""


@dataclass(frozen=True)
class Test:
    """One test run: its command and how long it takes."""

    command: Command
    seconds: float


def runs_of(mechanism: Mechanism, stepped: str = "micro") -> dict[str, Test]:
    """Return the six test runs of a mechanism by name; "micro" ones are in half or full steps where `stepped` says so.

    The base rate is 0.98 of the resonance of the load on the gear's spring, rotor held; its half, its double
    and the sweep's end (2.4 times it) are multiples of it.
    """
    resonance_hz = math.sqrt(mechanism.value("gear.stiffness") / mechanism.value("load.inertia")) / (2.0 * math.pi)
    rate = round(0.98 * resonance_hz, 1)
    sweep = RateProfile.through([(0.0, 0.0), (20.0, 2.4 * rate)])
    command = partial(_command, mechanism)
    return {
        "full_res": Test(command("full", RateProfile.constant(rate)), 1.0),
        "full_half": Test(command("full", RateProfile.constant(rate / 2.0)), 1.0),
        "full_slow": Test(command("full", RateProfile.constant(5.0)), 1.5),
        "micro_res": Test(command(stepped, RateProfile.constant(rate)), 1.0),
        "micro_2res": Test(command(stepped, RateProfile.constant(2.0 * rate)), 1.0),
        "sweep": Test(command(stepped, sweep), 20.0),
    }


def _command(mechanism: Mechanism, stepping: str, rate: RateProfile) -> Command:
    """Return a command; half windings are switched, and full steps of two phases begin between them."""
    phases = mechanism.plant.layout.phases
    command = Command(
        stepping=stepping,
        microsteps={"full": 1, "half": 2, "micro": 16}[stepping],
        rate=rate,
        start_angle_deg=45.0 if stepping == "full" and phases != STAR else 0.0,
        waveform="square" if phases == UNIPOLAR else "cosine",
    )
    return mechanism.command_for(command)


def campaign(start: Mechanism, truth: Mechanism, seed: int, variant: str, stepped: str = "micro") -> Campaign:
    """Return the campaign of a mechanism, to be identified from `start`.

    Records common to two variants are equal sample by sample.
    """
    runs = runs_of(truth, stepped)
    generators = np.random.default_rng((seed, 1)).spawn(len(runs))
    records = tuple(
        record_of(name, _measured(truth, run, rng), run.command)
        for (name, run), rng in zip(runs.items(), generators, strict=True)
        if name != VARIANTS[variant]
    )
    return Campaign(path=Path("campaign.toml"), mechanism_path=Path("mechanism.toml"), mechanism=start, records=records)


def _measured(truth: Mechanism, run: Test, rng: np.random.Generator) -> np.ndarray:
    torque = torque_of(truth, run)
    offset, drift = rng.normal(0.0, (OFFSET_NM, DRIFT_NM))
    noise = NOISE_NM * rng.standard_normal(torque.size)
    return torque + noise + offset + drift * np.linspace(0.0, 1.0, torque.size)


def torque_of(mechanism: Mechanism, run: Test) -> np.ndarray:
    """Return what the mechanism's torque is in a test run, N m."""
    base = TimeBase(RATE_HZ, round(run.seconds * RATE_HZ) + 1)
    simulator = Simulator(mechanism.plant, run.command, base)
    return simulate_run(simulator.run(mechanism.kernel_values(), substeps=SUBSTEPS)).torque


def record_of(name: str, torque: np.ndarray, command: Command) -> CampaignRecord:
    """Return a record that holds a torque, N m."""
    path = Path(f"{name}.csv")
    channel = Channel(quantity="torque", unit="N*m", data=torque, role=Role.OUTPUT, column="torque_Nm")
    delay = Parameter(name=record_parameter_name(name, TIME_OFFSET.key), declaration=TIME_OFFSET, value=0.0)
    data = Record(name=name, path=path, digest="", time_start_s=0.0, sample_rate_hz=RATE_HZ, channels=(channel,))
    return CampaignRecord(
        name=name,
        use="estimate",
        command=command,
        spec=RecordSpec(name=name, path=path.name),
        file=path,
        parameters=(delay,),
        data=data,
    )
