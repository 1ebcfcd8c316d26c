"""The margins of a requirement, one-way and two-way, and which of them decides whether it is met."""

from __future__ import annotations

from typing import Any

from mechid.budgets.requirement import Standing


def margins(standing: Standing, two_way_rad: float | None) -> dict[str, Any]:
    """Return the two-way margin, None where it is not known, and the one that decides, as plain dicts.

    The joined mechanism and structure decide where they were worked out, since they leave nothing out; else one-way.
    What is met is judged by the lower 95 % limit of the margin that decides, the first of its `margin95`.

    The level that decides is of that coupling, with its standard error and the parts of it.

    Parameters
    ----------
    standing : Standing
        One-way.
    two_way_rad : float or None
        Level of the nominal unit over time, the structure's modes joined with the mechanism.
    """
    two_way = None if two_way_rad is None else _scaled(standing, two_way_rad)
    if two_way is not None:
        return {"two_way": two_way, "decided": {"coupling": "two-way", **two_way}}
    return {"two_way": two_way, "decided": {"coupling": "one-way", **_margin(standing, 1.0)}}


def _scaled(standing: Standing, two_way_rad: float) -> dict[str, Any] | None:
    """Return the one-way level and its band, scaled as the nominal unit's level is."""
    return _margin(standing, two_way_rad / standing.nominal_rad) if standing.nominal_rad > 0.0 else None


def _margin(standing: Standing, scale: float) -> dict[str, Any]:
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
