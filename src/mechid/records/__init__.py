"""What was measured: records of transducers, read from files and checked, in SI.

`read_record` makes a `Record` of a file and of what the campaign says about it (`RecordSpec`).
"""

from mechid.records.components import COMPONENTS, Mounting, about_mounting_point
from mechid.records.formats import READERS, open_table, read_record
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
    "about_mounting_point",
    "open_table",
    "read_record",
    "samplings",
]
