"""Versions of the installation, which have to agree where results are to agree to the last bit."""

from __future__ import annotations

import hashlib
import platform
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

LIBRARIES = ("numpy", "scipy", "numba")


@lru_cache(maxsize=1)
def installation() -> str:
    """Return in a line what results depend on: mechid with a digest of its sources, Python, the numerical libraries."""
    python = ".".join(platform.python_version_tuple()[:2])
    others = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return f"mechid {source_digest()}, Python {python}, {others}"


def source_digest() -> str:
    """Return the version of mechid and a digest of its sources: other code may go another way."""
    root = Path(__file__).parents[2]
    total = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        total.update(file.read_bytes())
    return f"{version('mechid')} {total.hexdigest()[:16]}"
