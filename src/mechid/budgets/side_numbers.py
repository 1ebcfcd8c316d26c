"""Other force and moment components of a budget as plain dicts."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.side_source import SideSource
from mechid.units import unit_words


def side_of_bench(source: SideSource | None) -> dict[str, Any]:
    """Return the mounting of the mechanism on the bench and the components that fly; empty without any."""
    if source is None:
        return {}
    mounting = source.measured.mounting
    return {
        "side": {
            "drive_axis": mounting.drive_axis,
            "mounting_point_m": list(mounting.point_m),
            "frame": source.frame.tolist(),
            "flying": list(source.flying_components),
            "left_out": dict(source.absent),
        }
    }


def side_of_mode(made: ModeBudget) -> dict[str, Any]:
    """Return the line-of-sight RMS of drive torque and each component at the worst rate; empty without any."""
    at = made.responses[made.worst]
    if at.side is None:
        return {}
    parts = np.sqrt(0.5 * np.sum(np.abs(at.side.parts()) ** 2, axis=0))
    alone = np.zeros(len(at.axes)) if at.side.alone is None else np.sqrt(at.side.alone.power.sum(axis=0))
    components = [
        {
            "name": name,
            "unit": unit_words(name),
            "coherent": int(np.count_nonzero(at.side.lines[:, k])),
            "by_magnitude": int(np.count_nonzero(at.side.bounds[:, k])),
            "line_of_sight_rms_rad": parts[:, k].tolist(),
        }
        for k, name in enumerate(at.side.here.components)
    ]
    return {
        "side": {
            "drive_rms_rad": at.of_drive().rms().tolist(),
            "components": components,
            "together_rms_rad": at.rms().tolist(),
            "alone_rms_rad": alone.tolist(),
            "far": at.side.here.far,
            "outside": at.side.here.outside,
        }
    }
