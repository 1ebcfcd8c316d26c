"""What was measured: records of transducers, read from files and checked, in SI.

`read_record` makes a `Record` of a file and of what the campaign says about it (`RecordSpec`).

The names here load what they need when they are first used: the process that reads files needs few of them.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.records.components import COMPONENTS, Mounting, move_to_mounting_point
    from mechid.records.formats import READERS, open_table, prepare_to_read, read_record
    from mechid.records.record import Channel, Record
    from mechid.records.sampling import Sampling, samplings
    from mechid.records.spec import ChannelSpec, Conditioning, RecordSpec, Role, TimeStamps
    from mechid.records.table import Column, Table

__all__ = [
    "COMPONENTS",
    "READERS",
    "Channel",
    "ChannelSpec",
    "Column",
    "Conditioning",
    "Mounting",
    "Record",
    "RecordSpec",
    "Role",
    "Sampling",
    "Table",
    "TimeStamps",
    "move_to_mounting_point",
    "open_table",
    "prepare_to_read",
    "read_record",
    "samplings",
]

_HOMES = {
    "COMPONENTS": "components",
    "READERS": "formats",
    "Channel": "record",
    "ChannelSpec": "spec",
    "Column": "table",
    "Conditioning": "spec",
    "Mounting": "components",
    "Record": "record",
    "RecordSpec": "spec",
    "Role": "spec",
    "Sampling": "sampling",
    "Table": "table",
    "TimeStamps": "spec",
    "move_to_mounting_point": "components",
    "open_table": "formats",
    "prepare_to_read": "formats",
    "read_record": "formats",
    "samplings": "sampling",
}


def __getattr__(name: str) -> object:
    """Return a public name, its home imported."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
