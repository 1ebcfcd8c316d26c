"""Fits of a small campaign in memory, and their optima."""

from dataclasses import replace

from mechid.campaign import Campaign, Stage
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit, Optimum
from synthetic import bench, bounded, truth


def campaign_of(*free: str, seconds: float = 0.2, seed: int = 6, **bounds: dict) -> Campaign:
    """Return a record of full steps of which some parameters are free; `bounds` by the last part of their key."""
    mechanism = truth().with_free(free)
    for name in free:
        if name.rpartition(".")[2] in bounds:
            mechanism = bounded(mechanism, name, **bounds[name.rpartition(".")[2]])
    campaign = bench(mechanism, truth(), "full_46", seed=seed, seconds=seconds)
    return replace(campaign, stages=(Stage(records=("full_46",), window_s=None, free=free),))


def identified(*free: str, **of: object) -> Fit:
    """Return the fit of such a campaign."""
    return identify(campaign_of(*free, **of))


def optimum(*free: str, **of: object) -> Optimum:
    """Return the optimum of such a fit."""
    return identified(*free, **of).optimum
