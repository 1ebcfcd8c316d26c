"""Analysis of finished fits: validation on each record, and comparison of hypotheses.

`validate` evaluates the prediction of every record of a fit, `compare` compares finished fits of the same records. The
names here are imported on first use: a comparison needs no simulator.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.analysis.comparison import Comparison, compare
    from mechid.analysis.validation import ChannelValidation, RecordValidation, validate, with_validation

__all__ = ["ChannelValidation", "Comparison", "RecordValidation", "compare", "validate", "with_validation"]


def __getattr__(name: str) -> object:
    """Import a public name on first use."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = "comparison" if name in ("Comparison", "compare") else "validation"
    value: object = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value
