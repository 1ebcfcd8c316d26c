"""Effects of the library that these records cannot carry: what a diagnosis did not look for, or not well enough."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.effects.scores import COLLINEAR, Landscape, Score
from mechid.identification.effects.selection import is_significant, scores_of_misfit, share_of_misfit
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES

NOT_LOOKED_FOR = "not looked for"


def out_of_reach(before: Model, model: Model) -> dict[str, str]:
    """Return the effects that the records could not be asked for, each with why.

    Parameters
    ----------
    before : Model
        The mechanism as written.
    model : Model
        That in which the search has ended.
    """
    plain = (before if math.isfinite(before.cost) else model).landscape()
    weak = _weak(model, plain if model is before else model.landscape()) if model.over_noise > RULES.followed else {}
    return {**weak, **not_carried(plain)}


def weighed(model: Model) -> dict[str, str]:
    """Return every effect looked for beside a model that leaves nothing to explain, each with why it is not named.

    The effect that comes nearest to what is asked for is first.
    """
    landscape = model.landscape()
    scores = sorted(landscape.scores().items(), key=lambda item: item[1].excess, reverse=True)
    whys = {
        name: f"would take {100.0 * share_of_misfit(model, s.share * model.cost):.2g} % of the misfit, chi-square "
        f"{s.chi_square:.3g} for {s.dof}; {_asked_for(s):.3g} is asked for"
        for name, s in scores
    }
    return whys | not_carried(landscape)


def not_carried(landscape: Landscape) -> dict[str, str]:
    """Return the effects that a score says nothing of, each with why."""
    free, unseen = landscape.free.shape[1], "these records do not show it, or not beside what is free already"
    whys = dict.fromkeys(landscape.failed, "the simulation with it fails where the fit has ended")
    for name, J in landscape.effects.items():
        if name in landscape.too_wide:
            whys[name] = (
                f"{J.shape[1]} numbers beside the {free} that are free are as many as the "
                f"{landscape.effective_samples:.3g} independent samples that these records are worth"
            )
        elif not _is_seen(landscape.free, J):
            whys[name] = unseen
    return {name: f"{NOT_LOOKED_FOR}: {why}" for name, why in whys.items()}


def _is_seen(free: FloatArray, further: FloatArray) -> bool:
    """Tell whether derivatives, (m, k), have a direction that those to what is free, (m, n), do not hold."""
    size = np.linalg.norm(free, axis=0)
    U, s, _ = np.linalg.svd(free / np.where(size > 0.0, size, 1.0), full_matrices=False)
    held = U[:, s > COLLINEAR]
    rest = further - held @ (held.T @ further)
    return bool(np.any(np.linalg.norm(rest, axis=0) > COLLINEAR * np.linalg.norm(further, axis=0)))


def _weak(model: Model, landscape: Landscape) -> Mapping[str, str]:
    """Return the effects that would take a share of what is left, which so few samples do not make sure."""
    scores = scores_of_misfit(model, landscape.scores())
    return {
        name: f"would take {100.0 * s.share:.3g} % of the misfit, with a chi-square of {s.chi_square:.3g} only: these "
        f"records are worth {s.effective_samples:.3g} independent samples, and {_asked_for(s):.3g} is asked for"
        for name, s in scores.items()
        if s.share >= RULES.share and not is_significant(s, RULES)
    }


def _asked_for(s: Score) -> float:
    """Return the chi-square from which an effect of a score's freedom counts."""
    return max(RULES.least_chi_square, s.chi_square - s.excess)
