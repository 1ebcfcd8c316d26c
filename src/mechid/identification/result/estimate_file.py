"""Writer and reader of estimate.json and of the mechanism file beside it."""

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
"""Tables that every reader needs."""
ERROR_TABLES = (*TABLES, "correlation")
"""Tables that a reader of the parameters' errors needs."""


def is_synthetic(content: Mapping[str, Any]) -> bool:
    """Tell whether an estimate.json marks its records as simulated; earlier versions wrote no such entry."""
    return content.get("synthetic") is True


def write_estimate(fit: Fit, path: Path | str) -> None:
    """Write a fit atomically; numbers that are not finite are written as null."""
    write_atomically(Path(path), estimate_text(fit))


def estimate_text(fit: Fit) -> str:
    """Return the content of estimate.json."""
    return json_text(fit.to_dict())


def json_text(value: Mapping[str, Any], *, indent: int | None = 1) -> str:
    """Return strict JSON with null for numbers that are not finite; on one line where `indent` is None."""
    return json.dumps(_replace_nonfinite(value), indent=indent, ensure_ascii=False, allow_nan=False) + "\n"


def read_estimate(path: Path | str, *, needs: Sequence[str] = TABLES) -> dict[str, Any]:
    """Return the checked content of an estimate.json.

    Parameters
    ----------
    path : Path
    needs : sequence of str
        Required tables at the top level.

    Raises
    ------
    InputFileError
        If the file is missing, damaged, or of another format.
    """
    path = Path(path)
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid identify" writes it') from error
    except NotADirectoryError as error:
        raise InputFileError(f"{path.parent} is not a folder; give the result folder of mechid identify") from error
    except UnicodeDecodeError as error:  # a ValueError: it has to be caught before that
        raise InputFileError(f"{path} is not UTF-8 text; identify anew") from error
    except OSError as error:
        raise InputFileError(f"{path} cannot be read ({error.strerror}); identify anew") from error
    except ValueError as error:
        raise InputFileError(f"{path}: is damaged ({error}); identify anew") from error
    if not isinstance(content, dict):
        raise InputFileError(f"{path} is not an estimate: found {json.dumps(content)[:40]}, no table; identify anew")
    found = content.get("format")
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}"')
    fault = _find_fault(content, needs)
    if fault:
        raise InputFileError(f"{path}: {fault}; the file is damaged or of another version, identify anew")
    return dict(content)


def _find_fault(content: Mapping[str, Any], needs: Sequence[str]) -> str:
    """Describe the first fault of the entries that every reader needs, with its place; empty where there is none."""
    missing = [key for key in needs if not isinstance(content.get(key), dict)]
    if missing:
        return f"{missing[0]}: missing"
    for name, entry in content["parameters"].items():
        if not isinstance(entry, dict) or not isinstance(entry.get("status"), str):
            return f"parameters.{name}.status: missing"
        value = entry.get("value")
        # bool is a subclass of int in Python, so JSON's true would pass as a number.
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return f"parameters.{name}.value: found {json.dumps(value)}, expected a finite number"
    if not isinstance(content["outcome"].get("code"), str):
        return "outcome.code: missing"
    if "grade" in content and content["grade"] not in list(Grade):
        return f"grade: found {json.dumps(content['grade'])}, expected one of {', '.join(Grade)}"
    faults = (_matrix_fault(content, key) for key in ("correlation", "covariance") if key in content)
    return next(filter(None, faults), "")


def _matrix_fault(content: Mapping[str, Any], key: str) -> str:
    """Describe the fault of a matrix over some parameters; empty where there is none. An unknown cell is null."""
    table = content[key]
    if not isinstance(table, dict):
        return f"{key}: found {json.dumps(table)[:40]}, expected a table of names and matrix"
    names, rows = table.get("names"), table.get("matrix")
    size = len(names) if isinstance(names, list) else 0
    if not isinstance(rows, list) or [len(r) if isinstance(r, list) else -1 for r in rows] != [size] * size:
        return f"{key}.matrix: is not {size} x {size}"
    strange = [name for name in names or () if not isinstance(name, str) or name not in content["parameters"]]
    if strange:
        return f"{key}.names: found {json.dumps(strange[0])[:40]}, expected the name of a parameter"
    # type(), not isinstance(): true and false would pass as integers.
    strange = [cell for row in rows for cell in row if type(cell) not in (int, float, type(None))]
    return f"{key}.matrix: found {json.dumps(strange[0])[:40]}, expected a number" if strange else ""


def _replace_nonfinite(value: Any) -> Any:
    """Convert a value to plain types: tuples to lists, and numbers that are not finite to None."""
    if isinstance(value, Mapping):
        return {str(key): _replace_nonfinite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_replace_nonfinite(entry) for entry in value]
    if isinstance(value, float):  # NumPy's double is a float too
        return float(value) if math.isfinite(value) else None
    return value


FILE, DIGEST, QUANTITIES, PLANT = "mechanism_file", "mechanism_sha256", "quantities", "plant"
"""Keys of the provenance: file name, SHA-256 of its bytes, measured quantities, digest of the equations."""
NEXT_STEP = "identify anew (for a budget, write values that differ in flight into its [flight] table)"


def provenance_of_fits(*digests: str) -> dict[str, Any]:
    """Return the entry ``fits`` of a result's JSON file, from the digests of the fits' mechanism files."""
    return {"fits": [{DIGEST: digest or None} for digest in digests]}


def sign_provenance(fit: Fit, name: str, text: str) -> Fit:
    """Add the name and the digest of the mechanism file beside the estimate to the fit's provenance."""
    own = {FILE: name, DIGEST: hashlib.sha256(text.encode()).hexdigest(), QUANTITIES: [*fit.mechanism.plant.outputs]}
    return replace(fit, provenance={**fit.provenance, **own})


def read_estimated_mechanism(provenance: object, path: Path) -> Mechanism:
    """Read the identified mechanism from the file beside its estimate.

    Parameters
    ----------
    provenance : mapping
        Provenance of the fit.
    path : Path
        Path of its estimate.json.

    Raises
    ------
    InputFileError
        If the mechanism file is absent, has changed, or has other equations than those that were identified.
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
            f"{file}: there is no such file; identify writes it beside {path.name}, and later commands read it: "
            "restore it, or identify anew"
        ) from error
    if found != digest:
        raise InputFileError(f"{file} is not the file that identify wrote beside {path.name}: {NEXT_STEP}")
    mechanism = load_mechanism(file)
    # The equations depend on the measured quantities: digests are comparable only for the same ones.
    measured = [q for q in provenance.get(QUANTITIES, ()) if q in mechanism.plant.offered]
    mechanism = replace(mechanism, plant=mechanism.plant.with_outputs(measured or [*mechanism.plant.outputs]))
    # The same text can give other equations, after a change of a user's own block or of mechid.
    if mechanism.plant.digest != provenance.get(PLANT):
        raise InputFileError(
            f"{path.name}: provenance.{PLANT}: the equations of {name} differ from those that were identified; "
            "a block of your own or mechid may have changed since; identify anew"
        )
    return mechanism
