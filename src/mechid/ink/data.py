"""What reports are made of: plain dicts of numbers and texts, which JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Data = Mapping[str, Any]
