"""A file that identify leaves beside estimate.json, read only if it is of the same fit."""

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


def read_beside(
    fit: Fit, name: str, form: str, stale: str, made: Callable[[Mapping[str, Any]], Content]
) -> Content | None:
    """Return what is made of a file's content; None where the fit was read from no folder, or that has no such file.

    Parameters
    ----------
    fit : Fit
        Read from a folder.
    name : str
        Of the file there.
    form : str
        The `format` that the file has to have.
    stale : str
        The remedy that ends a message.
    made : callable
        Makes the result of the content; a missing key or a wrong type there is damage of the file.

    Raises
    ------
    InputFileError
        The file is damaged, or of another fit.
    """
    if fit.folder is None:
        return None
    path = fit.folder / name
    try:
        content = json.loads(read_result(path))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise InputFileError(f"{path}: is damaged ({error}); {stale}") from error
    try:
        if content["format"] != form or content["orders"] != list(TRACKED):
            raise InputFileError(f"{path}: is of another version of mechid; {stale}")
        if content["provenance"] != fit.provenance:
            raise InputFileError(f"{path}: is of another fit than estimate.json beside it; {stale}")
        return made(content)
    except (KeyError, TypeError, ValueError) as error:
        raise InputFileError(f"{path}: is damaged at {error}; {stale}") from error
