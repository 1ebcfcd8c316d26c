"""What new files start from: the catalogue of the paper's mechanism, also the demo's start, or another example."""

from __future__ import annotations

from mechid.campaign.catalogue_values import CATALOGUES
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.errors import UsageError, did_you_mean
from mechid.plant.layout import STEPPER_GEAR_MASS
from mechid.plant.mechanism import Mechanism


def catalogue_mechanism(assembly: str = STEPPER_GEAR_MASS) -> Mechanism:
    """Return the mechanism that new files of an assembly start from.

    Parameters
    ----------
    assembly : str
        As docs/blocks/assemblies.md names them.

    Returns
    -------
    Mechanism
        With values of a catalogue, in the file's units; the paper's has 15 unknown parameters free.

    Raises
    ------
    UsageError
        There is no such assembly.

    Examples
    --------
    >>> import mechid
    >>> len(mechid.catalogue_mechanism().free)
    15
    """
    if assembly not in CATALOGUES:
        near = did_you_mean(assembly, CATALOGUES) or "; there are " + ", ".join(CATALOGUES)
        raise UsageError(f'assembly: unknown "{assembly}"{near}')
    return mechanism_from_table({ASSEMBLY: assembly, **CATALOGUES[assembly]}, "catalogue")
