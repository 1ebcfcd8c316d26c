"""Settings of bootstrap and profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RefitSettings:
    """Steps and limits of refits about an optimum."""

    warm_up: int = 20_000
    """Samples drawn and dropped before those of a coloured record, until it has forgotten where it began. Poles of
    radius 0.999 have fallen to 2e-9 by then."""
    chord_steps: int = 6
    """Most chord steps: two or three bring a draw to its optimum, and where six do not, a threshold lies between."""
    most_numbers: int = 100_000_000
    """Derivatives that are kept; beyond, each draw is refitted as any record is. They take 0.8 GB."""
    weak: float = 1e-12
    """Share of the largest eigenvalue below which a direction is not seen: rounding of squares is some 1e-16."""
    jump: float = 1.2
    """Growth of the root of the cost's rise between neighbours that is looked into: three steps in one."""
    halvings: int = 10
    """Halvings of the gap between two points where the cost jumps: to a thousandth of it."""

    # The others are choices; no benchmark distinguishes values near them.

    elsewhere: float = 1e-6
    """Chance at which a distance from the estimate, in its own covariance, is no scatter any more."""
    step: float = 0.4
    """Growth of that root from point to point of a profile."""
    most_steps: int = 60
    """Steps on each side of a profile."""
    coloured: float = 1.1
    """Robust over white variance from which colour counts."""


REFIT = RefitSettings()
