"""Optima of fits of small campaigns in memory."""

from dataclasses import replace

from mechid.campaign import Stage
from mechid.identification.identify import identify
from mechid.identification.result.optimum import Optimum
from synthetic import bench, bounded, truth


def optimum(*free: str, seconds: float = 0.2, seed: int = 6, **bounds: dict) -> Optimum:
    """Return the optimum of a fit of full steps in which some parameters are free; `bounds` by the key's last part."""
    mechanism = truth().with_free(free)
    for name in free:
        if name.rpartition(".")[2] in bounds:
            mechanism = bounded(mechanism, name, **bounds[name.rpartition(".")[2]])
    campaign = bench(mechanism, truth(), "full_46", seed=seed, seconds=seconds)
    stage = Stage(records=("full_46",), window_s=None, free=free)
    campaign = replace(campaign, stages=(stage,))
    return identify(campaign).optimum
