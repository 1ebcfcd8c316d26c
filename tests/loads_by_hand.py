"""Records of loads from arrays, without a file."""

from pathlib import Path

import numpy as np

from mechid.records import Record
from mechid.records.record import Channel
from mechid.records.spec import Role


def record_of(channels, sample_rate_hz=1000.0, bridged=None):
    """Return a record of channels by quantity, (N,) each; `bridged` names samples by quantity."""
    return Record(
        name="r",
        path=Path("r.csv"),
        digest="0" * 64,
        time_start_s=0.0,
        sample_rate_hz=sample_rate_hz,
        channels=tuple(
            Channel(
                quantity=quantity,
                unit="V",
                data=np.ascontiguousarray(data, dtype=np.float64),
                role=Role.OUTPUT if quantity == "torque" else Role.SIDE,
                column=quantity,
                bridged=np.array((bridged or {}).get(quantity, []), dtype=np.int64),
            )
            for quantity, data in channels.items()
        ),
    )
