"""Diagnose: what a mechanism file lacks, as the records of a finished fit say it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from scipy.special import chdtrc

from mechid.errors import FitError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, Progress, Tell, silent
from mechid.identification.computation.workforce import working_on
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.pictures import Pictures, pictures_of
from mechid.identification.diagnosis.proposal import HeldOut, Proposal, held_out, hum_left, proposal_of
from mechid.identification.diagnosis.search import Found, searched
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.steps import Step
from mechid.identification.diagnosis.stretches import in_stretches, reach
from mechid.identification.diagnosis.unexplained import NOT_LOOKED_FOR, Locked, locked, out_of_reach, weighed
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.refit.rebuild import grade_lines, refuse_other_files
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Cause, Grade
from mechid.identification.result.missing import Missing
from mechid.plant.mechanism import Mechanism
from mechid.shown import Shown

LOST = (Cause.USED_IN_PART, Cause.NOT_FOLLOWED, Cause.OUT_OF_STEP, Cause.LEFT_OUT)
"""Causes of grade C that are of a record which the fit has not followed to its end."""


@dataclass(frozen=True, kw_only=True)
class Tried:
    """An effect that was fitted and is not named: what it is, and why not."""

    name: str
    words: str
    why: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Diagnosis(Shown):
    """What a mechanism file lacks.

    Attributes
    ----------
    missing : tuple of Missing
        The effects that the records ask for, that which explains most first; one entry for effects that these records
        cannot tell apart.
    unexplained : float
        Share of the misfit that is left with them; 0 where that is within the noise.
    words : str
        What is said of the whole, in a sentence or two.
    tried : tuple of Tried
    steps : tuple of Step
        How the search went.
    over_noise : (float, float)
        RMS of what the mechanism as written leaves, and of what it leaves with the effects, over that of the noise.
    mechanism : Mechanism or None
        With the effects, at the values that they have together; None where none is named.
    as_written : Step
        Cost and criterion of the mechanism as written, before any step.
    pictures : Pictures
        Where in frequency each effect acts, and what is drawn of what is left; by the names of `missing`.
    locked : tuple of Locked
        What a residual that nothing explains goes with; empty where effects are named.
    held_out : tuple of HeldOut
        How well each record that was held out is predicted; empty where no effect is named.
    share : float
        Share of all samples of the records that was diagnosed: 1, or as far as any model was found to follow them.
    synthetic : bool
        Whether the records were simulated.
    fit_digest : str
        `Fit.mechanism_digest` of the diagnosed fit.
    """

    missing: tuple[Missing, ...]
    unexplained: float
    words: str
    tried: tuple[Tried, ...]
    steps: tuple[Step, ...]
    over_noise: tuple[float, float]
    mechanism: Mechanism | None
    as_written: Step
    pictures: Pictures
    locked: tuple[Locked, ...]
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
    """Say which effects the records of a finished fit ask for, and which these records cannot tell apart.

    Nothing of the fit is changed: what is found is said and proposed.

    Parameters
    ----------
    fit : Fit
        Holds its campaign, the records read.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        Whose workers do the work, as `distributed.Client.get_executor()`; None leaves it to threads.
    listener : callable
        Called with each report of progress.

    Raises
    ------
    InputFileError
        A file of the campaign is not the one that was identified.
    FitError
        The fit has failed.
    """
    refuse_other_files(fit)
    if fit.grade is Grade.FAILED:
        raise FitError(" ".join(["a failed fit cannot be diagnosed:", *grade_lines(fit)]))
    with one_core_algebra(), working_on(executor):
        before, start = initial_models(fit, workers=workers or os.cpu_count() or 1)

        def say(words: str) -> None:
            listener(Progress(1, 1, "diagnosis", words, None, 0.0))

        found = _found(before, start, fit.grade, say)
        say("effects are drawn")
        concluded = _concluded(found, hum_left(found.model, fit), _in_part(fit, found.model))
        predicted = held_out(found.before, found.model, fit) if concluded.mechanism else ()
        return replace(concluded, held_out=predicted, synthetic=fit.synthetic or fit.required_campaign.synthetic)


def _found(before: Model, start: Model, grade: Grade, say: Tell) -> Found:
    """Return the effects that are missing: from the fit, and from the first moments where that may be a wrong branch.

    A fit of grade C may be; and so may another one where what is found leaves far more than noise.
    """
    if grade is Grade.C:
        other = in_stretches(before, say)
        if other is None or other.is_of_whole_records:
            return _searched(before, _better(start, other), say)
        start = start.at_levels(other.problem)
        partly = other.share > reach(start)
        return _searched(before.where(other), other, say) if partly else _searched(before, start, say)
    found = _searched(before, start, say)
    if found.model.over_noise <= RULES.far:
        return found
    other = in_stretches(before, say)
    other = _better(found.model, other if other and other.is_of_whole_records else None)
    return found if other is found.model else _searched(before, other, say)


def _better(model: Model, other: Model | None) -> Model:
    if other is None:
        return model
    return other if other.cost < model.at_levels(other.problem).cost else model


def _searched(before: Model, start: Model, say: Tell) -> Found:
    """Return the effects that the records ask for, at noise levels no higher than what is left with them."""
    start = start.lowered()
    while True:
        found = searched(before.at_levels(start.problem), start, say)
        quieter = found.model.lowered()
        if quieter is found.model:
            return found
        start = quieter


def _in_part(fit: Fit, model: Model) -> str:
    """Return what is to be said of a fit that follows its records in part; empty of another one."""
    if fit.grade is not Grade.C:
        return ""
    lost = {reason.record: None for reason in fit.reasons if reason.cause in LOST}
    these = f", {', '.join(name for name in lost if name)} among them," if any(lost) else ""
    of = f"all records of the fit{these} from beginning to end"
    if not model.is_of_whole_records:
        of = f"the first {100.0 * model.share:.3g} % of all samples, which is as far as any model was found to follow"
    return (
        f"The fit is of grade C. This diagnosis is of {of}, so that an effect named here may stand for a wrong branch "
        "of the search: identify again with it before you believe it."
    )


def _concluded(found: Found, hum: list[Missing], in_part: str) -> Diagnosis:
    model, named = found.model, bool(found.model.effects)
    words = model.words
    is_complete = not (named or found.left or found.refused)
    beyond = {} if is_complete else out_of_reach(found.before, model)
    looked_for = weighed(model) if is_complete else beyond
    whys = [(name, why) for name, why in {**looked_for, **found.tried}.items() if name not in model.effects]
    tried = [Tried(name=name, words=words.get(name, name), why=why) for name, why in whys]
    proposal = proposal_of(model) if named else None
    goes_with = locked(model) if found.left else ()
    missing = [*hum, *(_missing(found, proposal, name, words) for name in found.needed if proposal)]
    return Diagnosis(
        missing=tuple(sorted(missing, key=lambda one: -one.chi_square)),
        unexplained=found.left,
        words=" ".join(filter(None, [_words(found), *(one.words for one in goes_with), _narrowed(beyond), in_part])),
        tried=tuple(tried),
        steps=found.steps,
        over_noise=(found.before.over_noise, model.over_noise),
        mechanism=proposal.mechanism if proposal else None,
        as_written=found.as_written,
        pictures=pictures_of(found, {name: _called(found.model, name) for name in found.less} if named else {}),
        locked=goes_with,
        held_out=(),
        share=model.share,
    )


def _narrowed(beyond: Mapping[str, str]) -> str:
    """Return that the library is wider than the records can carry; empty where it is not."""
    names = [name for name, why in beyond.items() if why.startswith(NOT_LOOKED_FOR)]
    if not names:
        return ""
    return f"Of {', '.join(names)} these records can tell nothing: see what was tried."


def _called(model: Model, name: str) -> str:
    """Return the name that an entry has: the order of a law is in its table."""
    return name.partition(":")[0] if name in model.laws else name


def _words(found: Found) -> str:
    ratio, left = found.before.over_noise, found.model.over_noise
    if not (found.model.effects or found.left or found.refused):
        return f"Nothing is left to explain: the mechanism as written leaves {ratio:.4g} times the noise."
    if not found.model.effects:
        return (
            f"Nothing in the library explains what is left, {ratio:.4g} times the noise: what comes near takes less "
            "than half of it, or many effects have to imitate it together, or parts of the records disagree on the "
            "values with it, so that none is named."
        )
    said = (
        f"The mechanism as written leaves {ratio:.4g} times the noise; with the effects below {left:.4g} times. "
        "They were found together, and each is needed: without it a fit is clearly worse."
    )
    return f"{said} Nothing in the library explains the rest." if found.left else said


def _missing(found: Found, proposal: Proposal, name: str, words: Mapping[str, str]) -> Missing:
    score, own = found.needed[name], proposal.own[name]
    table = next((n.rpartition(".")[0] for n in own), "")
    is_disturbance = name in found.model.disturbances
    return Missing(
        name=_called(found.model, name),
        words=words.get(name, name),
        parameters=own,
        chi_square=score.chi_square,
        dof=score.dof,
        share=score.share,
        p_value=float(chdtrc(score.dof, score.chi_square)),
        records=_records(found.less[name], found.model),
        toml=proposal.tomls[name],
        block="" if is_disturbance else table.rstrip(".0123456789"),
        aliases=found.like.get(name, ()),
    )


def _records(less: Model, model: Model) -> tuple[str, ...]:
    """Return the records that are followed worse without an effect."""
    windows = model.setting.windows
    pairs = zip(less.problem.norms(less.q, windows), model.problem.norms(model.q, windows), strict=True)
    falls = [one**2 - other**2 for one, other in pairs]
    names = [t.name for t in model.setting.problem.targets if t.name in windows]
    return tuple(name for name, fall in zip(names, falls, strict=True) if fall > RULES.least_chi_square)
