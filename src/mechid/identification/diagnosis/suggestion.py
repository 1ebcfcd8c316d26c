"""What a fit that misses something leaves to be explained, by its derivatives alone: the short form of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from scipy.special import chdtrc

from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.start import model_of_fit
from mechid.identification.effects.selection import likely_effects
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing import Suggested


def with_suggestions(fit: Fit, workers: int = 1, say: Callable[[str], None] = lambda line: None) -> Fit:
    """Return a fit of grade B or C with the effects that its residual asks for, each by itself and none of them fitted.

    One with added terms has found them already, and gets none.
    """
    if fit.grade not in (Grade.B, Grade.C) or fit.as_written:
        return fit
    say("asking the residual what the model is missing ...")
    with one_core_algebra():
        model = model_of_fit(fit, workers=workers)
        return replace(fit, suggested=_suggested(model))


def _suggested(model: Model) -> tuple[Suggested, ...]:
    scores, words = model.scores(), model.words
    return tuple(
        Suggested(
            name=name,
            words=words[name],
            chi_square=one.chi_square,
            dof=one.dof,
            share=one.share,
            p_value=float(chdtrc(one.dof, one.chi_square)),
        )
        for name, one in ((name, scores[name]) for name in likely_effects(model, scores)[: RULES.suggested])
    )
