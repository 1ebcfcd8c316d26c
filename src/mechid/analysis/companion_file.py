"""Reader of companion files of estimate.json, which have to belong to the same fit."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from mechid.analysis.residual_emission import TRACKED
from mechid.errors import InputFileError
from mechid.reading.whole import read_result

if TYPE_CHECKING:
    from mechid.identification.result.fit import Fit

Content = TypeVar("Content")


def read_companion(
    fit: Fit, name: str, form: str, remedy: str, parse: Callable[[Mapping[str, Any]], Content]
) -> Content | None:
    """Read a companion file of a fit; None if the fit has no folder, or the folder no such file.

    Parameters
    ----------
    fit : Fit
        Fit, usually read from a folder.
    name : str
        Name of the file.
    form : str
        Required value of the key ``format``.
    remedy : str
        Remedy at the end of messages.
    parse : callable
        Converts the content; a missing key or a wrong type counts as damage of the file.

    Raises
    ------
    InputFileError
        The file is damaged or belongs to another fit.
    """
    if fit.folder is None:
        return None
    path = fit.folder / name
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise InputFileError(f"{path}: is damaged ({error}); {remedy}") from error
    try:
        if content["format"] != form or content["orders"] != list(TRACKED):
            raise InputFileError(f"{path}: is of another version of mechid; {remedy}")
        if content["provenance"] != fit.provenance:
            raise InputFileError(f"{path}: is of another fit than estimate.json beside it; {remedy}")
        return parse(content)
    except (KeyError, TypeError, ValueError) as error:
        raise InputFileError(f"{path}: is damaged at {error}; {remedy}") from error
