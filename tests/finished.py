"""Optima of small in-memory campaigns, taken up again from what estimate.json would hold."""

import json
from dataclasses import replace

from mechid.campaign import Stage
from mechid.identification.identify import identify
from mechid.identification.refit.reopened import Optimum, reopened
from mechid.identification.result.estimate_file import estimate_text
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
    return reopened(campaign, json.loads(estimate_text(identify(campaign))))
