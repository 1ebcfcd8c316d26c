"""Mechanisms with catalogue values, from which new files and the demo start."""

from __future__ import annotations

from mechid.campaign.catalogue_values import CATALOGUES
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.errors import UsageError, did_you_mean
from mechid.plant.layout import STEPPER_GEAR_MASS
from mechid.plant.mechanism import Mechanism


def catalogue_mechanism(assembly: str = STEPPER_GEAR_MASS) -> Mechanism:
    """Return an example mechanism of an assembly, with catalogue values.

    Parameters
    ----------
    assembly : str
        One of the names in docs/blocks/assemblies.md.

    Returns
    -------
    Mechanism
        Catalogue values in the file's units; the mechanism of the paper has 15 free parameters.

    Raises
    ------
    UsageError
        The assembly is unknown.

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
