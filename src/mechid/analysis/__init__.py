"""Judgement of a finished fit: its records predicted and judged, and hypotheses side by side.

`validate` judges every record of a fit, `compare` sets finished fits of the same records against each other. The names
here load what they need when they are first used: a comparison needs no simulator.

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
    """Return a public name, its home imported."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = "comparison" if name in ("Comparison", "compare") else "validation"
    value: object = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value
