"""Preference among hypotheses, with its strength and reasons in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from mechid.analysis.criteria import Score
from mechid.analysis.hypothesis import LEFT_OUT, Hypothesis
from mechid.analysis.settings import RESIDUAL
from mechid.parameter import Status

LEVELS = ((2.0, "hardly"), (6.0, "slightly"), (10.0, "clearly"), (math.inf, "decisively"))
"""Upper limits of criterion differences, in words; after Burnham and Anderson, Kass and Raftery."""
MEANINGFUL = LEVELS[0][0]
"""Smallest meaningful difference of a criterion."""


class ComparisonOutcome(Enum):
    """Outcome of a comparison; the value is the sentence shown to the user."""

    AGREED = "The criteria and the records held out prefer the same hypothesis."
    UNTESTED = "The criteria prefer one hypothesis; no record was held out to test its prediction."
    UNDECIDED_BY_PREDICTION = "The criteria prefer one hypothesis; the records held out are predicted equally well."
    DISPUTED = "The criteria prefer one hypothesis, the records held out another: the difference is not due to noise."
    CRITERIA_DISAGREE = "AIC and BIC prefer different hypotheses: only one justifies the additional parameters."
    OPEN = "The records do not separate the hypotheses; the simpler one will do."
    ONLY_ONE = "Only one of the fits came to an optimum; the others show what they reached, not what they could reach."
    NONE = "None of the fits came to an optimum, so none can be preferred."

    @property
    def code(self) -> str:
        """Short name for use in programs."""
        return self.name.lower()


UNDECIDED = (ComparisonOutcome.OPEN, ComparisonOutcome.CRITERIA_DISAGREE)
"""Outcomes without a preferred hypothesis."""


@dataclass(frozen=True, kw_only=True)
class Preference:
    """Outcome, name of the preferred hypothesis or None, and reasons as sentences."""

    outcome: ComparisonOutcome
    preferred: str | None
    grounds: tuple[str, ...]


def preference(hypotheses: Sequence[Hypothesis], scores: Sequence[Score]) -> Preference:
    """Determine the preferred hypothesis and the reasons."""
    by_name = {h.name: h for h in hypotheses}
    succeeded = [s for s in scores if by_name[s.hypothesis].outcome.has_optimum and math.isfinite(s.aic_effective)]
    lost = [_why_lost(by_name[s.hypothesis]) for s in scores if s not in succeeded]
    if not succeeded:
        return Preference(outcome=ComparisonOutcome.NONE, preferred=None, grounds=tuple(lost))
    ranked = sorted(succeeded, key=lambda s: s.aic_effective)
    best, outcome = ranked[0], _outcome(ranked)
    grounds = [_margin(best, other) for other in ranked[1:]]
    grounds += [_relation(by_name[best.hypothesis], by_name[s.hypothesis]) for s in ranked[1:]]
    return Preference(
        outcome=outcome,
        preferred=None if outcome in UNDECIDED else best.hypothesis,
        grounds=(*grounds, *_held_out_words(scores, by_name), *lost),
    )


def _why_lost(hypothesis: Hypothesis) -> str:
    unfollowed = "a record it was estimated from cannot be simulated to its end with its values"
    return f"{hypothesis.name}: {unfollowed if hypothesis.outcome.has_optimum else hypothesis.outcome.value}"


def _outcome(ranked: Sequence[Score]) -> ComparisonOutcome:
    """Return the outcome for scores sorted by AIC."""
    if len(ranked) == 1:
        return ComparisonOutcome.ONLY_ONE
    best = ranked[0]
    if ranked[1].aic_effective - best.aic_effective < MEANINGFUL:
        return ComparisonOutcome.OPEN
    # BIC penalises parameters more; if it disagrees, the extra parameters are not supported clearly.
    if min(ranked, key=lambda s: s.bic_effective) is not best:
        return ComparisonOutcome.CRITERIA_DISAGREE
    if not any(s.held_out for s in ranked):
        return ComparisonOutcome.UNTESTED
    gap = best.held_out - min(s.held_out for s in ranked[1:])
    if math.isnan(gap) or abs(gap) < MEANINGFUL:
        return ComparisonOutcome.UNDECIDED_BY_PREDICTION
    return ComparisonOutcome.AGREED if gap < 0.0 else ComparisonOutcome.DISPUTED


def strength_word(difference: float) -> str:
    """Describe a criterion difference in one word.

    Examples
    --------
    >>> strength_word(0.5), strength_word(7.0), strength_word(4000.0)
    ('hardly', 'clearly', 'decisively')
    """
    return next(word for limit, word in LEVELS if difference < limit or limit == math.inf)


def _margin(best: Score, other: Score) -> str:
    aic, bic = other.aic_effective - best.aic_effective, other.bic_effective - best.bic_effective
    differences = f"AIC {aic:+.4g}, BIC {bic:+.4g} of the other, by effective samples"
    if bic < 0.0:
        return f"{best.hypothesis} before {other.hypothesis} by AIC, behind it by BIC ({differences})"
    return f"{best.hypothesis} {strength_word(min(aic, bic))} before {other.hypothesis} ({differences})"


def _relation(best: Hypothesis, other: Hypothesis) -> str:
    pair = f"{best.name} and {other.name}"
    large, small = (best, other) if len(best.adjustable) >= len(other.adjustable) else (other, best)
    same_known = all(
        small.parameters[name].value == p.value
        for name, p in large.parameters.items()
        if name in small.parameters and small.parameters[name].status == p.status == Status.KNOWN
    )
    if _commands(best) != _commands(other) or not same_known or not small.adjustable <= large.adjustable:
        return f"{pair} are not nested: no likelihood-ratio test applies, the criteria and the prediction do"
    more = len(large.adjustable) - len(small.adjustable)
    if more == 0:
        return f"{pair} have the same free parameters"
    return f"{pair} are nested: {large.name} has {more} free parameter{'s' if more > 1 else ''} more"


def _commands(hypothesis: Hypothesis) -> dict[str, Mapping[str, object]]:
    return {name: r.command for name, r in hypothesis.records.items()}


def _held_out_words(scores: Sequence[Score], by_name: Mapping[str, Hypothesis]) -> tuple[str, ...]:
    predicted = sorted(scores, key=lambda s: s.held_out)
    first = by_name[scores[0].hypothesis]
    uses = {"held out": first.used_for("validate"), LEFT_OUT: first.used_for(LEFT_OUT)}
    return tuple(
        f"{words}, {record.name}: {_residuals(record.name, predicted, by_name)}"
        for words, records in uses.items()
        for record in records
    )


def _residuals(name: str, predicted: Sequence[Score], by_name: Mapping[str, Hypothesis]) -> str:
    found = ((s.hypothesis, by_name[s.hypothesis].records[name].residual_rms) for s in predicted)
    return ", ".join(f"{h} {'not followed' if math.isnan(rms) else f'{rms:.4g} N m RMS'}" for h, rms in found)


def _cut_short(hypothesis: Hypothesis) -> str:
    records = hypothesis.used_for("estimate")
    used, all_ = sum(r.used for r in records), sum(r.samples for r in records)
    return f"{hypothesis.name}: the fit itself counted {used} of {all_} samples, the criteria count all"


def cautions(hypotheses: Sequence[Hypothesis], scores: Sequence[Score]) -> tuple[str, ...]:
    """Return the limitations of a comparison, one line each."""
    lines = [_cut_short(h) for h in hypotheses if any(r.used < r.samples for r in h.used_for("estimate"))]
    share = scores[0].effective_samples / scores[0].samples
    if share < RESIDUAL.white:
        lines.append(
            f"residuals are coloured: {scores[0].samples:.0f} samples are worth {scores[0].effective_samples:.0f}; "
            "AIC and BIC by all samples are overconfident, those by effective samples decide"
        )
    most = max(s.fitted_count for s in scores)
    if scores[0].effective_samples < RESIDUAL.ample * most:
        lines.append(
            f"{scores[0].effective_samples:.0f} effective samples for up to {most} fitted numbers: the criteria are "
            "rough here, trust the records held out before them"
        )
    return tuple(lines)
