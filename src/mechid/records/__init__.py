"""What was measured: records of transducers, read from files and checked, in SI.

`read_record` makes a `Record` of a file and of what the campaign says about it (`RecordSpec`).
"""

from mechid.records.formats import READERS, read_record
from mechid.records.record import Channel, Record
from mechid.records.spec import ChannelSpec, RecordSpec, Role

__all__ = ["READERS", "Channel", "ChannelSpec", "Record", "RecordSpec", "Role", "read_record"]
