"""Commands of a stepper: the instants of its (micro)steps and the phase voltages that each sets.

`Command` represents a record's ``command`` table; ``Command.excitation`` returns the step edges
and the normalised phase voltages that drive the plant.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.command.excitation import Excitation
from mechid.command.measured import InputChannel, MeasuredCommand
from mechid.command.rate import RateProfile
from mechid.command.rate_table import read_rate_table
from mechid.command.stepping import Command, Start, Stepping
from mechid.command.timing import ClockReference, Timing
from mechid.command.waveform import Waveform

__all__ = [
    "ClockReference",
    "Command",
    "Excitation",
    "InputChannel",
    "MeasuredCommand",
    "RateProfile",
    "Start",
    "Stepping",
    "Timing",
    "Waveform",
    "read_rate_table",
]
