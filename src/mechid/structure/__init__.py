"""What the mechanism is mounted on: from a torque at its interface to the line of sight and to the interface.

`read_structure` makes a `Structure` from a file, `from_state_space` from a system of scipy.signal or python-control.

Internal to mechid but for the names that docs/python.md lists.
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
