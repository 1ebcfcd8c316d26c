"""Prediction of held-out records by a mechanism, as written and with the effects that are named."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mechid.identification.diagnosis.candidate import Model
from mechid.identification.identify import make_problem
from mechid.identification.result.as_fitted import campaign_as_fitted
from mechid.identification.result.fit import Fit


@dataclass(frozen=True, kw_only=True)
class HeldOut:
    """A record that was not fitted: RMS of what is left of it over its noise, offset and drift removed.

    Attributes
    ----------
    record : str
    before, after : float
        As written, and with the effects.
    """

    record: str
    before: float
    after: float


def held_out(before: Model, after: Model, fit: Fit) -> tuple[HeldOut, ...]:
    """Return how well each record that was held out is predicted, with what the fit found on its first part."""
    campaign = campaign_as_fitted(fit.required_campaign, fit, disturbances=False)
    kept = tuple(replace(r, use="estimate") for r in campaign.records if r.use == "validate")
    if not kept:
        return ()
    mechanism = before.setting.problem.space.mechanism
    problem = make_problem(replace(campaign, mechanism=mechanism, records=kept), before.setting.problem.workers)
    setting = replace(before.setting, problem=problem, windows=problem.whole(), disturbances=())

    def norms(model: Model) -> list[float]:
        values = model.problem.coordinates.values(model.q)
        there = replace(model, setting=setting, disturbances=()).at(values)
        return there.problem.norms(there.q, setting.windows)

    counts = [t.samples * len(t.channels) for t in problem.targets]
    return tuple(
        HeldOut(record=t.name, before=one / n**0.5, after=other / n**0.5)
        for t, n, one, other in zip(problem.targets, counts, norms(before), norms(after), strict=True)
    )
