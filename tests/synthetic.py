"""Synthetic campaigns held in memory: records simulated from a truth, with seeded noise, offset and drift."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from mechid.campaign import Campaign, CampaignRecord, Match, Stage, catalogue_mechanism
from mechid.campaign.bench import TRUTH
from mechid.campaign.campaign import TIME_OFFSET, record_parameter_name
from mechid.campaign.identify_options import IdentifyOptions
from mechid.command import Command, Timing
from mechid.identification.output_error.target import Target
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism
from mechid.records import Record, RecordSpec
from mechid.records.record import Channel
from mechid.records.spec import Role
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from paper import constant

RATE_HZ = 10_000.0
NOISE_NM = 0.002
OFFSET_NM = 0.01
DRIFT_NM = 0.004
SUBSTEPS = 4
"""Steps a sample with which the records are made; the identification begins with 1."""
AS_WRITTEN = IdentifyOptions(terms=False, disturbances="none")
"""Options of a fit that looks for no effects: each law that is tried has a kernel to compile."""
COMMANDS: Mapping[str, Command] = MappingProxyType(
    {
        "full_46": constant(46.0),
        "full_23": constant(23.0),
        "micro_46": constant(46.0, microsteps=16, start_angle_deg=0.0),
        "micro_92": constant(92.0, microsteps=16, start_angle_deg=0.0),
    }
)
"""Of the paper's kind: full steps at and below the resonance, microsteps at and above it."""


def truth(changes: Mapping[str, float] | None = None) -> Mechanism:
    """Return the mechanism of the demo, its 15 parameters free in the catalogue's bounds."""
    return catalogue_mechanism().with_values({**TRUTH, **(changes or {})})


def displaced(mechanism: Mechanism, factors: Mapping[str, float]) -> Mechanism:
    """Return a mechanism with the parameters named free, each its factor away, and all others known."""
    moved = {name: mechanism.value(name) * factor for name, factor in factors.items()}
    return mechanism.with_free(tuple(factors)).with_values(moved)


def bounded(mechanism: Mechanism, name: str, **bounds: float) -> Mechanism:
    """Return a mechanism in which one parameter has other bounds, its value moved inside."""
    q = replace(mechanism.parameters[name], **bounds)
    value = min(max(q.value, q.min), q.max)
    return mechanism.with_parameters({name: replace(q, value=value)})


def torque_of(mechanism: Mechanism, command: Command, samples: int, *, time_offset_s=0.0) -> np.ndarray:
    """Return the torque of a mechanism under a command, (samples,) N m."""
    simulator = Simulator(mechanism.plant, command, TimeBase(RATE_HZ, samples), latest_s=abs(time_offset_s))
    run = simulator.run(mechanism.kernel_values(), substeps=SUBSTEPS, timing=Timing(time_offset_s))
    return simulate_run(run).torque


def record(
    name: str,
    torque: np.ndarray,
    command: Command,
    *,
    time_offset: Mapping[str, float] | None = None,
    offset=True,
    drift=True,
    use="estimate",
    rate_hz=RATE_HZ,
) -> CampaignRecord:
    """Return a record that holds a torque; `time_offset` are value, min and max where it is free."""
    channel = Channel(quantity="torque", unit="N*m", data=torque, role=Role.OUTPUT, column="torque_Nm")
    path = Path(f"{name}.csv")
    status = Status.FREE if time_offset else Status.KNOWN
    own = Parameter(
        name=record_parameter_name(name, TIME_OFFSET.key),
        declaration=TIME_OFFSET,
        status=status,
        **(time_offset or {"value": 0.0}),
    )
    data = Record(name=name, path=path, digest="", time_start_s=0.0, sample_rate_hz=rate_hz, channels=(channel,))
    return CampaignRecord(
        name=name,
        use=use,
        command=command,
        spec=RecordSpec(name=name, path=path.name),
        file=path,
        matches=(Match(offset=offset, drift=drift),),
        parameters=(own,),
        data=data,
    )


def measured(
    mechanism: Mechanism, command: Command, rng: np.random.Generator, *, seconds: float, time_offset_s=0.0
) -> np.ndarray:
    """Return what a transducer would read: torque, white noise, an offset and a drift over the record."""
    torque = torque_of(mechanism, command, round(seconds * RATE_HZ) + 1, time_offset_s=time_offset_s)
    noise = NOISE_NM * rng.standard_normal(torque.size)
    return torque + noise + OFFSET_NM + DRIFT_NM * np.linspace(0.0, 1.0, torque.size)


def measuring(target: Target, y: np.ndarray) -> Target:
    """Return a target whose leading channel measures something else."""
    return with_leading(target, measured=y)


def with_leading(target: Target, **changes) -> Target:
    """Return a target whose leading channel is changed."""
    return replace(target, channels=(replace(target.leading, **changes), *target.channels[1:]))


def campaign(mechanism: Mechanism, *records: CampaignRecord, stages: tuple[Stage, ...] = ()) -> Campaign:
    """Return a campaign in memory."""
    return Campaign(
        path=Path("campaign.toml"),
        mechanism_path=Path("mechanism.toml"),
        mechanism=mechanism,
        records=records,
        stages=stages,
    )


def bench(
    start: Mechanism, made_by: Mechanism, *names: str, seed: int, seconds: float, stages: tuple[Stage, ...] = ()
) -> Campaign:
    """Return a campaign of records of `COMMANDS` by name, made by one mechanism, to be fitted from another."""
    rng = np.random.default_rng(seed)
    records = [record(name, measured(made_by, COMMANDS[name], rng, seconds=seconds), COMMANDS[name]) for name in names]
    return campaign(start, *records, stages=stages)
