"""Transfer functions of the supporting structure, from a torque at the interface to the line of sight and interface.

`read_structure` reads a `Structure` from a file; `from_state_space` converts a system of scipy.signal or
python-control.

Internal to mechid except for the names listed in docs/python.md.
"""

from mechid.structure.formats import read_structure
from mechid.structure.linear_system import from_state_space
from mechid.structure.modes import Modes
from mechid.structure.response import FrequencyResponse
from mechid.structure.selection import Location, Selection
from mechid.structure.structure import Structure

__all__ = [
    "FrequencyResponse",
    "Location",
    "Modes",
    "Selection",
    "Structure",
    "from_state_space",
    "read_structure",
]
