"""The kinds of inputs, a module for each family: builders, and what is asked of mechid for each."""

from fuzz.kinds.arrays import ARRAYS
from fuzz.kinds.commands import COMMANDS
from fuzz.kinds.hdf5 import HDF5
from fuzz.kinds.instruments import INSTRUMENTS
from fuzz.kinds.nastran import NASTRAN
from fuzz.kinds.own_blocks import OWN_BLOCKS
from fuzz.kinds.structures import STRUCTURES
from fuzz.kinds.texts import TEXTS

KINDS = (*TEXTS, *STRUCTURES, *ARRAYS, *HDF5, *INSTRUMENTS, *COMMANDS, *NASTRAN, *OWN_BLOCKS)
