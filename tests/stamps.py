"""Time stamps without a file."""

from dataclasses import dataclass

from mechid.errors import RecordError


@dataclass
class Stamps:
    """A table that knows no more than to say the row."""

    columns: tuple = ("time_s",)

    def error(self, message, row=None):
        return RecordError(f"row {row}: {message}")
