"""diagnose.json: a diagnosis written down, read again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from mechid.errors import InputFileError
from mechid.identification.result.missing import Missing
from mechid.reading.whole import read_result

FORMAT = "mechid-diagnosis/1"
FILE_NAME, PROPOSED_NAME = "diagnose.json", "mechanism_proposed.toml"
REMEDY = "diagnose anew (mechid diagnose FIT --out DIR)"


def read_diagnosis(path: Path | str) -> dict[str, Any]:
    """Return what a diagnose.json holds; its ``missing`` are `Missing`.

    Raises
    ------
    InputFileError
        The file is missing, damaged, or not of the format.
    """
    path = Path(path)
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid diagnose" writes it') from error
    except NotADirectoryError as error:
        raise InputFileError(f"{path.parent}: is no folder; give the result folder of mechid diagnose") from error
    except (OSError, ValueError) as error:
        raise InputFileError(f"{path}: cannot be read ({' '.join(str(error).split())}); {REMEDY}") from error
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}", {REMEDY}')
    try:
        return _checked(content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise InputFileError(f"{path}: is damaged at {what}; {REMEDY}") from error


def _checked(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content with what every reader rests on; KeyError or TypeError where that is not there."""
    known = {field.name for field in fields(Missing)}
    missing = [Missing.from_dict({k: v for k, v in one.items() if k in known}) for one in content["missing"]]
    tried = [{key: str(one[key]) for key in ("name", "words", "why")} for one in content["tried"]]
    unexplained = {"share": float(content["unexplained"]["share"]), "words": str(content["unexplained"]["words"])}
    over_noise = {key: float(content["over_noise"][key]) for key in ("as_written", "with_effects")}
    return {**content, "missing": missing, "tried": tried, "unexplained": unexplained, "over_noise": over_noise}
