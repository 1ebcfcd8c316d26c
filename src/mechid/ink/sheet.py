"""Sheet: content of one figure on paper, as plain data for the drawing process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FOLDER_NAME = "figures"


@dataclass(frozen=True)
class Sheet:
    """Figure before it is drawn.

    Attributes
    ----------
    name : str
        Name of its files.
    height_in : float
        Height in inches; the width is two columns.
    drawing : str
        Name of the function in `mechid.ink.drawings` that draws it.
    data : mapping
        Arguments of that function: texts, numbers, arrays.
    """

    name: str
    height_in: float
    drawing: str
    data: Mapping[str, Any]
