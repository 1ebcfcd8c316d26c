"""A sheet: what one figure on paper is to show, as plain data for the process that draws it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FOLDER_NAME = "figures"


@dataclass(frozen=True)
class Sheet:
    """A figure that is not drawn yet.

    Attributes
    ----------
    name : str
        Of its files.
    height_in : float
        Inches; it is two columns wide.
    drawing : str
        Which function of `mechid.ink.drawings` draws it.
    data : mapping
        What that function is given: texts, numbers, arrays.
    """

    name: str
    height_in: float
    drawing: str
    data: Mapping[str, Any]
