"""Simulation of all records of a campaign at the values of the mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mechid.campaign import Campaign
from mechid.campaign.prediction import simulate_all
from mechid.display import DisplayedResult
from mechid.simulation.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Simulated(DisplayedResult):
    """Simulated records.

    Attributes
    ----------
    trajectories : mapping of str to Trajectory
        Trajectories by record name.
    campaign : Campaign or None
        Campaign of the records; None for a single trajectory.
    """

    trajectories: Mapping[str, Trajectory]
    campaign: Campaign | None = None


def simulate_campaign(
    campaign: Campaign, *, sample_rate_hz: float | None = None, duration_s: float | None = None
) -> Simulated:
    """Simulate every record of a campaign, without noise.

    Parameters
    ----------
    campaign : Campaign
    sample_rate_hz, duration_s : float or None
        As for `mechid.simulate_all`, whose errors are raised.

    Returns
    -------
    Simulated
        Its `write` saves samples as CSV, numbers, page and figures.
    """
    runs = simulate_all(campaign, sample_rate_hz=sample_rate_hz, duration_s=duration_s)
    return Simulated(trajectories=runs, campaign=campaign)
