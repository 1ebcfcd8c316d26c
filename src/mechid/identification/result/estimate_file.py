"""estimate.json: a fit written down, and read again."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.errors import InputFileError
from mechid.identification.result.fit import FORMAT, Fit
from mechid.writing import write_whole

FILE_NAME = "estimate.json"


def write_estimate(fit: Fit, path: Path | str) -> None:
    """Write a fit; whole or not at all. What is not finite is written as null."""
    write_whole(Path(path), estimate_text(fit))


def estimate_text(fit: Fit) -> str:
    """Return the content of estimate.json."""
    return json_text(fit.to_dict())


def json_text(value: Mapping[str, Any]) -> str:
    """Return strict JSON, with null for what is not finite."""
    return json.dumps(_finite(value), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_estimate(path: Path | str) -> dict[str, Any]:
    """Return what an estimate.json holds.

    Raises
    ------
    InputFileError
        The file is missing, no JSON, or not of the format.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid identify" writes it') from error
    except (OSError, ValueError) as error:
        raise InputFileError(f"{path}: cannot be read ({error}); identify anew") from error
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}"')
    return dict(content)


def _finite(value: Any) -> Any:
    """Return the value with plain types, tuples as lists and None for what is not finite."""
    if isinstance(value, Mapping):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float):  # NumPy's double is one too
        return float(value) if math.isfinite(value) else None
    return value
