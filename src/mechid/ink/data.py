"""Data of reports: plain dicts of numbers and texts that JSON can represent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Data = Mapping[str, Any]
