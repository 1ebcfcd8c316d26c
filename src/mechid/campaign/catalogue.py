"""The catalogue of the paper's mechanism: the example that new files start from, and the demo's start."""

from __future__ import annotations

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.plant.mechanism import Mechanism


def catalogue_mechanism() -> Mechanism:
    """Return the catalogue's mechanism, its 15 unknown parameters free."""
    return mechanism_from_table(CATALOGUE, "catalogue")
