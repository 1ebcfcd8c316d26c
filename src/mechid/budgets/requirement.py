"""A requirement on the line of sight, and how an error stands against it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.budgets.indices import Index
from mechid.budgets.levels import worst_share
from mechid.budgets.shares import Band


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """A line of the requirements.

    Parameters
    ----------
    name : str
    index : Index
    axis : str
        A line of sight of the structure, or ``"cone"``: the angle between wanted and actual direction.
    limit_rad : float
    interpretation : str
        "temporal", "ensemble" or "mixed".
    confidence : float
    evaluation_period_s : float
        Over which the error is looked at; windows fit into it.
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
        """Share of an ensemble's members that are no worse than the worst one that counts; None where none does."""
        return worst_share(self.confidence) if self.interpretation == "temporal" else None


@dataclass(frozen=True, kw_only=True)
class Standing:
    """How a mode of operation stands against a requirement.

    Attributes
    ----------
    level : Band
        rad at the requirement's confidence.
    nominal_rad : float
        The level over time of the nominal unit.
    sampling_rad : float
        Standard error that the level has since the ensemble is drawn; it is part of the band.
    ecss_rad : float
        The same as `level` by the standard's own summation, |mean| + n_p sigma.
    others_rad : float
        The level over time of the other sources alone, while the mechanism rests.
    residual_rad : float
        By how much the level is larger for what the model lacks and the bench's records have left.
    spread_shares : mapping of str to float
        Who makes the levels differ within the ensemble: shares of their variance.
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
        """Share of the limit that is left; negative where it is exceeded."""
        return 1.0 - self.level.value / self.requirement.limit_rad

    @property
    def margin95(self) -> tuple[float, float]:
        """95 % interval of the margin by the level's band."""
        low, high = self.level.ci95
        return 1.0 - high / self.requirement.limit_rad, 1.0 - low / self.requirement.limit_rad
