"""Settings of bootstrap and profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RefitSettings:
    """Steps and limits of refits about an optimum."""

    warm_up: int = 20_000
    """Samples drawn and dropped before those of a coloured record, until it has forgotten its initial state. Poles of
    radius 0.999 have decayed to 2e-9 by then."""
    chord_steps: int = 6
    """Largest number of chord steps: two or three reach the optimum of a draw; if six do not, a threshold lies
    between."""
    most_numbers: int = 100_000_000
    """Largest number of stored derivatives, 0.8 GB; above it each draw is refitted by the general solver."""
    weak: float = 1e-12
    """Share of the largest eigenvalue below which a direction is invisible; squares round at some 1e-16."""
    jump: float = 1.2
    """Growth of the root of the cost's rise between neighbours from which the gap is bisected: three usual steps."""
    halvings: int = 10
    """Bisections of the gap at a jump of the cost, down to a thousandth of the gap."""

    # The others are choices; no benchmark distinguishes values near them.

    elsewhere: float = 1e-6
    """Probability of a distance from the estimate, in its covariance, below which it is not scatter by noise."""
    step: float = 0.4
    """Growth of that root from point to point of a profile."""
    most_steps: int = 60
    """Largest number of steps on each side of a profile."""
    coloured: float = 1.1
    """Ratio of robust to white variance from which colour counts."""


REFIT = RefitSettings()
