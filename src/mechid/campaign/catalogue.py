"""What new files start from: the catalogue of the paper's mechanism, also the demo's start, or another example."""

from __future__ import annotations

from mechid.campaign.catalogue_values import CATALOGUES
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.plant.layout import STEPPER_GEAR_MASS
from mechid.plant.mechanism import Mechanism


def catalogue_mechanism(assembly: str = STEPPER_GEAR_MASS) -> Mechanism:
    """Return the mechanism that new files of an assembly start from; the paper's has 15 unknown parameters free."""
    return mechanism_from_table({ASSEMBLY: assembly, **CATALOGUES[assembly]}, "catalogue")
