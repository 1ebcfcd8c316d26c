"""Diagnosis of a mechanism file: missing effects that the records of a finished fit support."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

from scipy.special import chdtrc

from mechid.display import DisplayedResult
from mechid.errors import FitError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, Progress, Tell, silent
from mechid.identification.computation.workforce import working_on
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.figure_data import FigureData, compute_figure_data
from mechid.identification.diagnosis.proposal import HeldOut, Proposal, build_proposal, confirmed_hum, predict_held_out
from mechid.identification.diagnosis.search import SearchResult, search_effects
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.steps import Step, hidden_law_layouts
from mechid.identification.diagnosis.stretches import followed_share, search_by_growth
from mechid.identification.diagnosis.unexplained_residual import (
    NOT_LOOKED_FOR,
    LockedLines,
    explain_omissions,
    explain_untested,
    locked_lines,
)
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.refit.rebuild import grade_lines, refuse_changed_files
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Cause, Grade
from mechid.identification.result.missing_effects import Missing
from mechid.identification.stages.kernel_precompilation import CompilationAhead
from mechid.plant.mechanism import Mechanism

LOST = (Cause.USED_IN_PART, Cause.NOT_FOLLOWED, Cause.OUT_OF_STEP, Cause.LEFT_OUT)
"""Causes of grade C that name a record which the fit does not follow to its end."""


@dataclass(frozen=True, kw_only=True)
class RejectedEffect:
    """An effect that was fitted but is not reported, with the reason."""

    name: str
    words: str
    why: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Diagnosis(DisplayedResult):
    """Effects that a mechanism file lacks.

    Attributes
    ----------
    missing : tuple of Missing
        Effects that the data support, the one that explains most first; one entry for effects that these records
        cannot separate.
    unexplained : float
        Share of the misfit that remains with them; 0 where the remaining residual is within the noise.
    words : str
        Summary in a sentence or two.
    tried : tuple of RejectedEffect
    steps : tuple of Step
        Steps of the search.
    over_noise : (float, float)
        Residual-to-noise ratio of the mechanism as written, and with the effects.
    mechanism : Mechanism or None
        The mechanism with the effects at their jointly fitted values; None where no effect is reported.
    as_written : Step
        Cost and criterion of the mechanism as written, before any step.
    pictures : FigureData
        Data of the figures: spectra of the effects and of the residual, by the names of `missing`.
    locked : tuple of Locked
        Lines of an unexplained residual over position or time; empty where effects are reported.
    held_out : tuple of HeldOut
        Prediction of each held-out record; empty where no effect is reported.
    share : float
        Diagnosed share of the records' samples: 1, or less where no model was found to follow them further.
    synthetic : bool
        Whether the records were simulated.
    fit_digest : str
        `Fit.mechanism_digest` of the diagnosed fit.
    """

    missing: tuple[Missing, ...]
    unexplained: float
    words: str
    tried: tuple[RejectedEffect, ...]
    steps: tuple[Step, ...]
    over_noise: tuple[float, float]
    mechanism: Mechanism | None
    as_written: Step
    pictures: FigureData
    locked: tuple[LockedLines, ...]
    held_out: tuple[HeldOut, ...]
    share: float = 1.0
    synthetic: bool = False
    fit_digest: str = ""


def diagnose(
    fit: Fit,
    *,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener = silent,
) -> Diagnosis:
    """Find effects that the records of a finished fit support, and effects that these records cannot separate.

    The fit is not changed; the result reports and proposes effects.

    Parameters
    ----------
    fit : Fit
        A fit that holds its campaign with the records read.
    workers : int or None
        Number of threads; None uses one per core.
    executor : concurrent.futures.Executor or None
        External executor for the work, such as `distributed.Client.get_executor()`; None uses threads.
    listener : callable
        Called with each report of progress.

    Raises
    ------
    InputFileError
        If a file of the campaign has changed since the identification.
    FitError
        If the fit failed.
    """
    refuse_changed_files(fit)
    if fit.grade is Grade.FAILED:
        raise FitError(" ".join(["a failed fit cannot be diagnosed:", *grade_lines(fit)]))
    with one_core_algebra(), working_on(executor):
        before, start = initial_models(fit, workers=workers or os.cpu_count() or 1)

        def say(words: str) -> None:
            listener(Progress(1, 1, "diagnosis", words, None, 0.0))

        with CompilationAhead() as ahead:
            # The landscape of all effects comes first, and takes longer to compile than the laws.
            if layouts := hidden_law_layouts(start):
                ahead.start(partial(iter, layouts))
            found = _find_effects(before, start, fit.grade, say)
        say("effects are drawn")
        concluded = _conclude(found, confirmed_hum(found.model, fit), _describe_partial(fit, found.model))
        predicted = predict_held_out(found.before, found.model, fit) if concluded.mechanism else ()
        return replace(concluded, held_out=predicted, synthetic=fit.synthetic or fit.required_campaign.synthetic)


def _find_effects(before: CandidateModel, start: CandidateModel, grade: Grade, say: Tell) -> SearchResult:
    """Find the missing effects from the fit, or from the records' first moments where the fit may be on a wrong branch.

    A fit of grade C may be on one, and so may any fit whose found effects leave far more than noise.
    """
    if grade is Grade.C:
        other = search_by_growth(before, say)
        if other is None or other.is_of_whole_records:
            return _search_at_lowered_levels(before, _better_model(start, other), say)
        start = start.at_levels(other.problem)
        partly = other.share > followed_share(start)
        return (
            _search_at_lowered_levels(before.move_to(other), other, say)
            if partly
            else _search_at_lowered_levels(before, start, say)
        )
    found = _search_at_lowered_levels(before, start, say)
    if found.model.over_noise <= RULES.far:
        return found
    other = search_by_growth(before, say)
    other = _better_model(found.model, other if other and other.is_of_whole_records else None)
    return found if other is found.model else _search_at_lowered_levels(before, other, say)


def _better_model(model: CandidateModel, other: CandidateModel | None) -> CandidateModel:
    if other is None:
        return model
    return other if other.cost < model.at_levels(other.problem).cost else model


def _search_at_lowered_levels(before: CandidateModel, start: CandidateModel, say: Tell) -> SearchResult:
    """Search for missing effects at noise levels no higher than the residual with them."""
    # Lower levels may show further effects, and these may lower the levels again.
    start = start.lower_levels()
    while True:
        found = search_effects(before.at_levels(start.problem), start, say)
        quieter = found.model.lower_levels()
        if quieter is found.model:
            return found
        start = quieter


def _describe_partial(fit: Fit, model: CandidateModel) -> str:
    """Describe the limits of a diagnosis of a grade C fit, which follows its records in part; else empty."""
    if fit.grade is not Grade.C:
        return ""
    lost = {reason.record: None for reason in fit.reasons if reason.cause in LOST}
    these = f", {', '.join(name for name in lost if name)} among them," if any(lost) else ""
    of = f"all records of the fit{these} from beginning to end"
    if not model.is_of_whole_records:
        of = f"the first {100.0 * model.share:.3g} % of all samples; no model was found that follows them further"
    return (
        f"The fit has grade C. This diagnosis covers {of}. An effect named here may only compensate for a wrong branch "
        "of the search: identify again with it before you rely on it."
    )


def _conclude(found: SearchResult, hum: list[Missing], in_part: str) -> Diagnosis:
    model, named = found.model, bool(found.model.effects)
    words = model.words
    is_complete = not (named or found.remaining_share or found.refused)
    beyond = {} if is_complete else explain_untested(found.before, model)
    looked_for = explain_omissions(model) if is_complete else beyond
    whys = [(name, why) for name, why in {**looked_for, **found.tried}.items() if name not in model.effects]
    tried = [RejectedEffect(name=name, words=words.get(name, name), why=why) for name, why in whys]
    proposal = build_proposal(model) if named else None
    goes_with = locked_lines(model) if found.remaining_share else ()
    missing = [*hum, *(_missing_entry(found, proposal, name, words) for name in found.needed if proposal)]
    return Diagnosis(
        missing=tuple(sorted(missing, key=lambda one: -one.chi_square)),
        unexplained=found.remaining_share,
        words=" ".join(
            filter(None, [_summarize(found), *(one.words for one in goes_with), _describe_untestable(beyond), in_part])
        ),
        tried=tuple(tried),
        steps=found.steps,
        over_noise=(found.before.over_noise, model.over_noise),
        mechanism=proposal.mechanism if proposal else None,
        as_written=found.as_written,
        pictures=compute_figure_data(
            found, {name: _entry_name(found.model, name) for name in found.less} if named else {}
        ),
        locked=goes_with,
        held_out=(),
        share=model.share,
    )


def _describe_untestable(beyond: Mapping[str, str]) -> str:
    """Report effects about which the records carry no information; empty where there are none."""
    names = [name for name, why in beyond.items() if why.startswith(NOT_LOOKED_FOR)]
    if not names:
        return ""
    return f"These records carry no information on {', '.join(names)}; see the effects tried."


def _entry_name(model: CandidateModel, name: str) -> str:
    """Return the name of an effect's entry; a law's entry has no order in its name, since its table holds that."""
    return name.partition(":")[0] if name in model.laws else name


def _summarize(found: SearchResult) -> str:
    ratio, left = found.before.over_noise, found.model.over_noise
    if not (found.model.effects or found.remaining_share or found.refused):
        return f"Nothing is left to explain: the residual of the mechanism as written is {ratio:.4g} times the noise."
    if not found.model.effects:
        return (
            f"Nothing in the library explains the residual, {ratio:.4g} times the noise: the best single candidate "
            "explains less than half of the misfit, or only many effects together imitate it, or parts of the records "
            "disagree on the candidate's values, so no effect is reported."
        )
    summary = (
        f"The residual of the mechanism as written is {ratio:.4g} times the noise; with the effects below it is "
        f"{left:.4g} times. The effects were found together, and each is needed: without it the fit is clearly worse."
    )
    return f"{summary} Nothing in the library explains the rest." if found.remaining_share else summary


def _missing_entry(found: SearchResult, proposal: Proposal, name: str, words: Mapping[str, str]) -> Missing:
    score, own = found.needed[name], proposal.own[name]
    table = next((n.rpartition(".")[0] for n in own), "")
    is_disturbance = name in found.model.disturbances
    return Missing(
        name=_entry_name(found.model, name),
        words=words.get(name, name),
        parameters=own,
        chi_square=score.chi_square,
        dof=score.dof,
        share=score.share,
        p_value=float(chdtrc(score.dof, score.chi_square)),
        records=_records_with_effect(found.less[name], found.model),
        toml=proposal.tomls[name],
        block="" if is_disturbance else table.rstrip(".0123456789"),
        aliases=found.like.get(name, ()),
    )


def _records_with_effect(less: CandidateModel, model: CandidateModel) -> tuple[str, ...]:
    """Return the records whose cost rises without an effect."""
    windows = model.setting.windows
    pairs = zip(less.problem.norms(less.q, windows), model.problem.norms(model.q, windows), strict=True)
    falls = [one**2 - other**2 for one, other in pairs]
    names = [t.name for t in model.setting.problem.targets if t.name in windows]
    return tuple(name for name, fall in zip(names, falls, strict=True) if fall > RULES.least_chi_square)
