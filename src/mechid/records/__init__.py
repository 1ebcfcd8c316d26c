"""Records of transducers, read from files, checked, and converted to SI units.

`read_record` creates a `Record` from a file and its declaration in the campaign (`RecordSpec`).

Names are imported from their modules on first use, because the reading process needs only a few of them.

Internal to mechid except for the names listed in docs/python.md.
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
    """Import a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    # Stored so that the next access finds the name without this function.
    globals()[name] = value
    return value
