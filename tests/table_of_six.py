"""A table of six components, synthetic: known lines of force and moment at the mounting point, and what it measures."""

from pathlib import Path

import numpy as np

from mechid.analysis.components_file import SideRecord, SideRecords
from mechid.analysis.side_components import side_components
from mechid.records import COMPONENTS, Mounting, Record, move_to_mounting_point
from mechid.records.record import Channel
from mechid.records.spec import Role

SAMPLE_RATE_HZ, SECONDS = 2000.0, 4.0
MOUNTING = Mounting("z", (0.02, -0.03, 0.06))
MEASURED = ("force_x", "force_y", "force_z", "moment_x", "moment_y")
NOISE = 1e-3
"""Standard deviation of a sample of each channel, N m and N."""


def signal(lines, steps):
    """Return the sum of lines, by order their complex amplitude, over travelled steps, (N,)."""
    return sum((np.real(c * np.exp(2j * np.pi * q * steps)) for q, c in lines.items()), np.zeros(steps.size))


def measured(exerted, rate, rng, noise=NOISE, seconds=SECONDS, mounting=MOUNTING):
    """Return a record of what a table measures of lines at the mounting point, by component and order.

    About the table's reference point, r x F more than about the mounting point; the moment about z is the drive torque.
    """
    steps = rate * np.arange(round(seconds * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    at_mount = np.column_stack([signal(exerted.get(name, {}), steps) for name in COMPONENTS])
    at_mount[:, 3:] += np.cross(mounting.point_m, at_mount[:, :3])
    table = at_mount + noise * rng.normal(size=at_mount.shape)
    named = dict(zip(COMPONENTS, table.T, strict=True))
    channels = [("torque", named["moment_z"], Role.OUTPUT), *((name, named[name], Role.SIDE) for name in MEASURED)]
    return Record(
        name="r",
        path=Path("r.csv"),
        digest="0" * 64,
        time_start_s=0.0,
        sample_rate_hz=SAMPLE_RATE_HZ,
        channels=tuple(
            Channel(
                quantity=q, unit="N*m" if q[0] in "mt" else "N", data=np.ascontiguousarray(data), role=role, column=q
            )
            for q, data, role in channels
        ),
    )


def tracked(record, rate, mounting=MOUNTING):
    """Return the lines of a record by rate, about the mounting point."""
    moved = move_to_mounting_point(record, mounting)
    steps = rate * np.arange(moved.samples) / SAMPLE_RATE_HZ
    return side_components([moved.channel(q).data for q in ("torque", *MEASURED)], steps, SAMPLE_RATE_HZ)


def side_records(exerted_at, rates, rng, **options):
    """Return the records of a bench that exerts `exerted_at(rate)` at each rate, in microsteps."""
    records = tuple(
        SideRecord(
            name=f"r{rate:g}",
            stepping="micro",
            microsteps=16,
            components=MEASURED,
            rates=tracked(measured(exerted_at(rate), rate, rng, **options), rate),
        )
        for rate in rates
    )
    return SideRecords(mounting=MOUNTING, records=records)
