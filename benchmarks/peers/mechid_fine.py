"""mechid with two integration steps a sample."""

from __future__ import annotations

from functools import partial

from . import mechid_side

NAME = "mechid, 2 steps"
REMARK = "kernel as generated, two steps a sample"
prepare = partial(mechid_side.prepare, substeps=2)
