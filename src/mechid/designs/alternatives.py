"""Alternative explanations of the same records, each fitted to them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mechid.designs.diagnosis_file import DiagnosedEffects
from mechid.designs.settings import DESIGN
from mechid.errors import InputFileError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.refit.rebuild import refuse_changed_files
from mechid.identification.result.diagnosis_file import PROPOSED_NAME
from mechid.identification.result.fit import Fit
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import extension_named, rivals_of, superset_of


@dataclass(frozen=True, eq=False)
class Group:
    """Alternative effects of which one is true, where the records do not decide which.

    Attributes
    ----------
    names : tuple of str
        Effect named by the diagnosis, followed by its aliases.
    models : tuple of CandidateModel
        Mechanism with each of them, and with all other effects of the diagnosis, at its optimum.
    """

    names: tuple[str, ...]
    models: tuple[CandidateModel, ...]

    @property
    def undecided(self) -> Group:
        """Alternatives that the records leave open: none of the others fits better by the threshold of a diagnosis."""
        best = min(model.cost for model in self.models)
        kept = [
            pair
            for pair in zip(self.names, self.models, strict=True)
            if pair[1].cost - best < IN_DIAGNOSIS.least_chi_square
        ]
        return Group(tuple(name for name, _ in kept), tuple(model for _, model in kept))


def rival_groups(
    fit: Fit,
    diagnosis: DiagnosedEffects,
    *,
    workers: int = 1,
    say: Callable[[str], None] = lambda line: None,
) -> tuple[Group, ...]:
    """Return the groups of alternatives of a diagnosis, each alternative fitted to the existing records.

    Parameters
    ----------
    fit : Fit
        Holds its campaign with the records read.
    diagnosis : DiagnosedEffects
        Diagnosis of that fit.
    workers : int
        Number of threads.
    say : callable
        Called with lines of progress.

    Raises
    ------
    InputFileError
        The diagnosis belongs to another campaign or fit.
    """
    if not diagnosis.groups:
        return ()
    refuse_changed_files(fit)
    with one_core_algebra():
        return _fitted_groups(fit, diagnosis, workers, say)


def _fitted_groups(
    fit: Fit,
    diagnosis: DiagnosedEffects,
    workers: int,
    say: Callable[[str], None],
) -> tuple[Group, ...]:
    say("the mechanism with the effects of the diagnosis")
    plain, _ = initial_models(fit, workers=workers)
    named = _diagnosed_model(plain, diagnosis)
    # The ratio depends on the records, so it also detects a diagnosis of others whose parameter names happen to fit.
    if abs(named.over_noise / diagnosis.over_noise - 1.0) > DESIGN.same_ratio:
        raise _mismatch_error(
            diagnosis,
            f"its mechanism leaves {named.over_noise:.4g} times the noise of these records, "
            f"not {diagnosis.over_noise:.4g} times as it says",
        )
    groups = []
    for effect in diagnosis.groups:
        models = [named]
        for alias in effect.aliases:
            say(f"{alias} in place of {effect.name} is fitted")
            models.append(_replace_effect(diagnosis, named, effect.name, alias))
        groups.append(Group((effect.name, *effect.aliases), refit_from_best(models)))
    return tuple(groups)


def refit_from_best(models: Sequence[CandidateModel]) -> tuple[CandidateModel, ...]:
    """Refit alternatives from the best of them as well, since one may have stopped in a local minimum."""
    best = min(models, key=lambda model: model.cost)
    again = (model if model is best else model.fit(best) for model in models)
    return tuple(min(one, other, key=lambda model: model.cost) for one, other in zip(models, again, strict=True))


def _mismatch_error(diagnosis: DiagnosedEffects, why: str) -> InputFileError:
    return InputFileError(
        f"{diagnosis.path}: belongs to another campaign or fit: {why}; run mechid diagnose on this fit"
    )


def _diagnosed_model(plain: CandidateModel, diagnosis: DiagnosedEffects) -> CandidateModel:
    """Return the mechanism with all effects of a diagnosis, at its values."""
    assert diagnosis.mechanism is not None
    model = plain
    for effect in diagnosis.effects:
        model = _add_effect(diagnosis, model, effect.name)
    if missing := [
        p.name for p in model.setting.problem.space.mechanism.free if p.name not in diagnosis.mechanism.parameters
    ]:
        raise _mismatch_error(diagnosis, f"{PROPOSED_NAME} has no {missing[0]}")
    values = {name: p.value for name, p in diagnosis.mechanism.parameters.items()}
    in_library = {wide: values[here] for wide, here in _entries(model, diagnosis.mechanism).items()}
    of_records = {
        n: p.value for e in diagnosis.effects if e.name in model.disturbances for n, p in e.parameters.items()
    }
    return model.at({**values, **in_library, **of_records})


def _entries(model: CandidateModel, proposed: Mechanism) -> dict[str, str]:
    """Return the name in the proposed file of each parameter of the model's terms, where each term stands alone."""
    alone = superset_of(model.base, only=model.terms, further=model.further) if model.terms else None
    if alone is None or model.library is None:
        return {}
    pairs: dict[str, str] = {}
    for term in model.terms:
        wide, here = ([n for n, t in of.items() if t == term] for of in (model.library.term_of, alone.term_of))
        pairs |= {w: h for w, h in zip(wide, here, strict=True) if h in proposed.parameters}
    return pairs


def _add_effect(diagnosis: DiagnosedEffects, model: CandidateModel, effect: str) -> CandidateModel:
    """Return a model with an additional effect, not fitted."""
    if model.library and effect in {t.name for t in model.library.terms}:
        return replace(model, terms=(*model.terms, effect))
    if effect in {one.name for one in model.setting.disturbances}:
        return replace(model, disturbances=(*model.disturbances, effect))
    if beyond := extension_named(model.base, effect):
        return _add_effect(diagnosis, model.add_candidates([beyond]), effect)
    law = next((law for law in rivals_of(model.base) if effect in (law.name, law.entry_name)), None)
    if law is None:
        raise _mismatch_error(diagnosis, f'"{effect}" is no effect that its mechanism or its records may have')
    return replace(model, base=law.mechanism, laws=(*model.laws, law.name))


def _replace_effect(diagnosis: DiagnosedEffects, model: CandidateModel, effect: str, alias: str) -> CandidateModel:
    """Return a fitted model with another effect in place of one of its terms or disturbances."""
    terms, others = (tuple(n for n in names if n != effect) for names in (model.terms, model.disturbances))
    return _add_effect(diagnosis, replace(model, terms=terms, disturbances=others), alias).fit(model)
