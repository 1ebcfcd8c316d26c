"""The mechanism file that identify leaves beside its estimate: read again, and held to be the one it left."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from mechid.campaign import read_mechanism
from mechid.errors import InputFileError
from mechid.identification.result.fit import Fit
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import read_bytes

FILE, DIGEST, QUANTITIES, PLANT = "mechanism_file", "mechanism_sha256", "quantities", "plant"
"""Keys of the provenance: the file's name, the SHA-256 of its bytes, what was measured, the equations' digest."""
NEXT = "identify anew (for a budget, what differs in flight belongs into its [flight] values)"


def signed(fit: Fit, name: str, text: str) -> Fit:
    """Return a fit whose provenance names the mechanism file left beside it, with the digest of that file's text."""
    own = {FILE: name, DIGEST: hashlib.sha256(text.encode()).hexdigest(), QUANTITIES: [*fit.mechanism.plant.outputs]}
    return replace(fit, provenance={**fit.provenance, **own})


def read_estimated_mechanism(provenance: object, path: Path) -> Mechanism:
    """Return the mechanism that was identified, from the file beside its estimate.

    Parameters
    ----------
    provenance : mapping
        Of the fit.
    path : Path
        Of its estimate.json.

    Raises
    ------
    InputFileError
        The mechanism file is absent, was changed since, or has other equations than those that were identified.
    """
    provenance = provenance if isinstance(provenance, Mapping) else {}
    digest, name = provenance.get(DIGEST), str(provenance.get(FILE, "mechanism.toml"))
    if not isinstance(digest, str):
        raise InputFileError(f"{path.name}: provenance.{DIGEST}: missing; an earlier mechid wrote it, identify anew")
    file = path.parent / name
    try:
        found = hashlib.sha256(read_bytes(file)).hexdigest()
    except OSError as error:
        raise InputFileError(
            f"{file}: there is no such file; identify leaves it beside {path.name}, and it is what is carried on: "
            "put it back, or identify anew"
        ) from error
    if found != digest:
        raise InputFileError(f"{file}: is not the file that identify left beside {path.name}: {NEXT}")
    mechanism = read_mechanism(file)
    measured = [q for q in provenance.get(QUANTITIES, ()) if q in mechanism.plant.offered]
    mechanism = replace(mechanism, plant=mechanism.plant.measuring(measured or [*mechanism.plant.outputs]))
    if mechanism.plant.digest != provenance.get(PLANT):
        raise InputFileError(
            f"{path.name}: provenance.{PLANT}: the equations of {name} are not those that were identified, as "
            "when a block of your own or mechid has changed since; identify anew"
        )
    return mechanism
