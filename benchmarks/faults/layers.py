"""The layer that fails: a module that Python loads before all others."""

import os
from pathlib import Path


def with_layer(fault: str) -> dict[str, str]:
    """Return the environment in which a fault happens, as ``"rename:3"``; see ``layer/sitecustomize.py``."""
    layer = str(Path(__file__).parent / "layer")
    return {"MECHID_FAULT": fault, "PYTHONPATH": os.pathsep.join([layer, os.environ.get("PYTHONPATH", "")])}
