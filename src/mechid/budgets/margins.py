"""Margins of a requirement, one-way and two-way, and the margin that decides."""

from __future__ import annotations

from typing import Any

from mechid.budgets.requirement import Standing


def margins(standing: Standing, two_way_rad: float | None) -> dict[str, Any]:
    """Return the two-way margin, None if unknown, and the margin that decides, as plain dicts.

    The coupled model decides where it was computed, since it neglects nothing; otherwise the one-way result decides. A
    requirement is met if the lower 95 % limit of the deciding margin, the first of its `margin95`, is not negative. The
    deciding level is given with its standard error and its contributions.

    Parameters
    ----------
    standing : Standing
        One-way.
    two_way_rad : float or None
        Level of the nominal unit over time, the structure's modes coupled with the mechanism.
    """
    two_way = None if two_way_rad is None else _two_way_margin(standing, two_way_rad)
    if two_way is not None:
        return {"two_way": two_way, "decided": {"coupling": "two-way", **two_way}}
    return {"two_way": two_way, "decided": {"coupling": "one-way", **_scaled_margin(standing, 1.0)}}


def _two_way_margin(standing: Standing, two_way_rad: float) -> dict[str, Any] | None:
    """Return the one-way level and its band, scaled by the two-way level of the nominal unit."""
    return _scaled_margin(standing, two_way_rad / standing.nominal_rad) if standing.nominal_rad > 0.0 else None


def _scaled_margin(standing: Standing, scale: float) -> dict[str, Any]:
    # 1 - margin is the level over the requirement, and scales with the level.
    low, high = (1.0 - scale * (1.0 - margin) for margin in standing.margin95)
    return {
        "level_rad": scale * standing.level.value,
        "sigma_rad": scale * standing.level.sigma,
        "sampling_sigma_rad": scale * standing.sampling_rad,
        "residual_rad": scale * standing.residual_rad,
        "margin": 1.0 - scale * (1.0 - standing.margin),
        "margin95": [low, high],
        "met": low >= 0.0,
    }
