"""Requirement on the line of sight, and the result of a mode against it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.budgets.indices import Index
from mechid.budgets.levels import worst_share
from mechid.budgets.shares import Band


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """Requirement on one pointing error index.

    Parameters
    ----------
    name : str
    index : Index
    axis : str
        A line of sight of the structure, or ``"cone"``: the angle between desired and actual direction.
    limit_rad : float
    interpretation : str
        "temporal", "ensemble" or "mixed".
    confidence : float
    evaluation_period_s : float
        Period of evaluation; all windows fit into it.
    """

    name: str
    index: Index
    axis: str
    limit_rad: float
    interpretation: str
    confidence: float
    evaluation_period_s: float

    @property
    def worst_member_share(self) -> float | None:
        """Share of an ensemble's members that do not exceed the reference worst one; None if no member is ranked."""
        return worst_share(self.confidence) if self.interpretation == "temporal" else None


@dataclass(frozen=True, kw_only=True)
class Standing:
    """Result of a mode of operation against a requirement.

    Attributes
    ----------
    level : Band
        rad at the requirement's confidence.
    nominal_rad : float
        Level over time of the nominal unit.
    sampling_rad : float
        Sampling standard error of the level over the drawn ensemble; part of the band.
    ecss_rad : float
        The level by the standard's own summation, |mean| + n_p sigma.
    others_rad : float
        Level over time of the other sources alone, while the mechanism rests.
    residual_rad : float
        Increase of the level due to unmodelled torque in the residuals of the bench's records.
    spread_shares : mapping of str to float
        Shares in the variance of the levels within the ensemble.
    """

    requirement: Requirement
    mode: str
    level: Band
    nominal_rad: float
    sampling_rad: float
    ecss_rad: float
    others_rad: float = 0.0
    residual_rad: float = 0.0
    spread_shares: Mapping[str, float] = field(default_factory=dict)

    @property
    def margin(self) -> float:
        """Remaining share of the limit; negative if the limit is exceeded."""
        return 1.0 - self.level.value / self.requirement.limit_rad

    @property
    def margin95(self) -> tuple[float, float]:
        """95 % interval of the margin, from the level's band."""
        low, high = self.level.ci95
        return 1.0 - high / self.requirement.limit_rad, 1.0 - low / self.requirement.limit_rad
