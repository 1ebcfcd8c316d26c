"""Reader of diagnose.json, the stored result of a diagnosis."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from mechid.errors import InputFileError
from mechid.identification.result.missing_effects import Missing
from mechid.reading.whole import read_result

FORMAT = "mechid-diagnosis/1"
FILE_NAME, PROPOSED_NAME = "diagnose.json", "mechanism_proposed.toml"
REMEDY = "diagnose anew (mechid diagnose FIT --out DIR)"


def read_diagnosis(path: Path | str) -> dict[str, Any]:
    """Return the content of a diagnose.json; the entries of its ``missing`` become `Missing`.

    Raises
    ------
    InputFileError
        If the file is missing, damaged, or of another format.
    """
    path = Path(path)
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid diagnose" writes it') from error
    except NotADirectoryError as error:
        raise InputFileError(f"{path.parent} is not a folder; give the result folder of mechid diagnose") from error
    except (OSError, ValueError) as error:
        raise InputFileError(f"{path} cannot be read ({' '.join(str(error).split())}); {REMEDY}") from error
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}", {REMEDY}')
    try:
        return _convert_entries(content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        place = " ".join(str(error).split()) or type(error).__name__
        raise InputFileError(f"{path}: is damaged at {place}; {REMEDY}") from error


def _convert_entries(content: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the entries that every reader needs; KeyError or TypeError where one is absent or of another type."""
    # Keys that a later version may add are left out, so that its files stay readable.
    known = {field.name for field in fields(Missing)}
    missing = [Missing.from_dict({k: v for k, v in one.items() if k in known}) for one in content["missing"]]
    tried = [{key: str(one[key]) for key in ("name", "words", "why")} for one in content["tried"]]
    unexplained = {"share": float(content["unexplained"]["share"]), "words": str(content["unexplained"]["words"])}
    over_noise = {key: float(content["over_noise"][key]) for key in ("as_written", "with_effects")}
    return {**content, "missing": missing, "tried": tried, "unexplained": unexplained, "over_noise": over_noise}
