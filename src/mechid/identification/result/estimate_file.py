"""estimate.json and the mechanism file beside it: a fit written down, and read again."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechid.campaign import load_mechanism
from mechid.errors import InputFileError
from mechid.identification.result.fit import FORMAT, Fit
from mechid.identification.result.grade import Grade
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import read_bytes, read_result
from mechid.writing import write_atomically

TABLES = ("outcome", "parameters")
"""Without these there is nothing to read."""
WITH_ERRORS = (*TABLES, "correlation")
"""What everybody rests on who carries the errors of the parameters on."""


def is_synthetic(content: Mapping[str, Any]) -> bool:
    """Tell whether an estimate.json says that its records were simulated; versions before that said nothing."""
    return content.get("synthetic") is True


def write_estimate(fit: Fit, path: Path | str) -> None:
    """Write a fit; whole or not at all. What is not finite is written as null."""
    write_atomically(Path(path), estimate_text(fit))


def estimate_text(fit: Fit) -> str:
    """Return the content of estimate.json."""
    return json_text(fit.to_dict())


def json_text(value: Mapping[str, Any], *, indent: int | None = 1) -> str:
    """Return strict JSON, with null for what is not finite; on one line where `indent` is None."""
    return json.dumps(_finite(value), indent=indent, ensure_ascii=False, allow_nan=False) + "\n"


def read_estimate(path: Path | str, *, needs: Sequence[str] = TABLES) -> dict[str, Any]:
    """Return what an estimate.json holds.

    Parameters
    ----------
    path : Path
    needs : sequence of str
        Tables at the top that have to be there.

    Raises
    ------
    InputFileError
        The file is missing, damaged, or not of the format.
    """
    path = Path(path)
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid identify" writes it') from error
    except NotADirectoryError as error:
        raise InputFileError(f"{path.parent}: is no folder; give the result folder of mechid identify") from error
    except UnicodeDecodeError as error:
        raise InputFileError(f"{path}: is not UTF-8 text; identify anew") from error
    except OSError as error:
        raise InputFileError(f"{path}: cannot be read ({error.strerror}); identify anew") from error
    except ValueError as error:
        raise InputFileError(f"{path}: is damaged ({error}); identify anew") from error
    if not isinstance(content, dict):
        raise InputFileError(f"{path}: is no table of an estimate, found {json.dumps(content)[:40]}; identify anew")
    found = content.get("format")
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}"')
    fault = _fault(content, needs)
    if fault:
        raise InputFileError(f"{path}: {fault}; it is damaged or of another version, identify anew")
    return dict(content)


def _fault(content: Mapping[str, Any], needs: Sequence[str]) -> str:
    """Return what every reader rests on and the content lacks, with its place; empty where nothing is missing."""
    missing = [key for key in needs if not isinstance(content.get(key), dict)]
    if missing:
        return f"{missing[0]}: missing"
    for name, entry in content["parameters"].items():
        if not isinstance(entry, dict) or not isinstance(entry.get("status"), str):
            return f"parameters.{name}.status: missing"
        value = entry.get("value")
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return f"parameters.{name}.value: found {json.dumps(value)}, no finite number"
    if not isinstance(content["outcome"].get("code"), str):
        return "outcome.code: missing"
    if "grade" in content and content["grade"] not in list(Grade):
        return f"grade: found {json.dumps(content['grade'])}, none of {', '.join(Grade)}"
    faults = (_matrix_fault(content, key) for key in ("correlation", "covariance") if key in content)
    return next(filter(None, faults), "")


def _matrix_fault(content: Mapping[str, Any], key: str) -> str:
    """Return what is wrong with a matrix over some of the parameters; null stands for what is not known."""
    table = content[key]
    if not isinstance(table, dict):
        return f"{key}: found {json.dumps(table)[:40]}, no table of names and matrix"
    names, rows = table.get("names"), table.get("matrix")
    size = len(names) if isinstance(names, list) else 0
    if not isinstance(rows, list) or [len(r) if isinstance(r, list) else -1 for r in rows] != [size] * size:
        return f"{key}.matrix: is not {size} x {size}"
    strange = [name for name in names or () if not isinstance(name, str) or name not in content["parameters"]]
    if strange:
        return f"{key}.names: found {json.dumps(strange[0])[:40]}, no parameter"
    strange = [cell for row in rows for cell in row if type(cell) not in (int, float, type(None))]
    return f"{key}.matrix: found {json.dumps(strange[0])[:40]}, no number" if strange else ""


def _finite(value: Any) -> Any:
    """Return the value with plain types, tuples as lists and None for what is not finite."""
    if isinstance(value, Mapping):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float):  # NumPy's double is one too
        return float(value) if math.isfinite(value) else None
    return value


FILE, DIGEST, QUANTITIES, PLANT = "mechanism_file", "mechanism_sha256", "quantities", "plant"
"""Keys of the provenance: the file's name, the SHA-256 of its bytes, what was measured, the equations' digest."""
NEXT = "identify anew (for a budget, what differs in flight belongs into its [flight] values)"


def provenance_of_fits(*digests: str) -> dict[str, Any]:
    """Return what a result's JSON file says of the fits that it is of, by the digests of their mechanism files."""
    return {"fits": [{DIGEST: digest or None} for digest in digests]}


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
    mechanism = load_mechanism(file)
    measured = [q for q in provenance.get(QUANTITIES, ()) if q in mechanism.plant.offered]
    mechanism = replace(mechanism, plant=mechanism.plant.measuring(measured or [*mechanism.plant.outputs]))
    if mechanism.plant.digest != provenance.get(PLANT):
        raise InputFileError(
            f"{path.name}: provenance.{PLANT}: the equations of {name} are not those that were identified, as "
            "when a block of your own or mechid has changed since; identify anew"
        )
    return mechanism
