"""Rival explanations of the same records, each at the values with which it explains them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mechid.designs.diagnosis_file import Diagnosed
from mechid.designs.settings import DESIGN
from mechid.errors import InputFileError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.refit.rebuild import refuse_changed_files
from mechid.identification.result.diagnosis_file import PROPOSED_NAME
from mechid.identification.result.fit import Fit
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import extension_named, rivals_of, superset_of


@dataclass(frozen=True, eq=False)
class Group:
    """Effects of which one is true, and the records do not tell which.

    Attributes
    ----------
    names : tuple of str
        That which the diagnosis names, then its aliases.
    models : tuple of Model
        The mechanism with each, and with whatever else the diagnosis names, at its optimum.
    """

    names: tuple[str, ...]
    models: tuple[Model, ...]

    @property
    def open(self) -> Group:
        """Those that the records leave open: none of the others explains them better by what a diagnosis asks for."""
        best = min(model.cost for model in self.models)
        kept = [
            pair
            for pair in zip(self.names, self.models, strict=True)
            if pair[1].cost - best < IN_DIAGNOSIS.least_chi_square
        ]
        return Group(tuple(name for name, _ in kept), tuple(model for _, model in kept))


def rival_groups(
    fit: Fit,
    diagnosis: Diagnosed,
    *,
    workers: int = 1,
    say: Callable[[str], None] = lambda line: None,
) -> tuple[Group, ...]:
    """Return the groups of rivals of a diagnosis, each rival fitted to the records that there are.

    Parameters
    ----------
    fit : Fit
        Holds its campaign, the records read.
    diagnosis : Diagnosed
        Of that fit.
    workers : int
        Threads.
    say : callable
        Of progress.

    Raises
    ------
    InputFileError
        The diagnosis is one of another campaign or fit.
    """
    if not diagnosis.groups:
        return ()
    refuse_changed_files(fit)
    with one_core_algebra():
        return _fitted_groups(fit, diagnosis, workers, say)


def _fitted_groups(
    fit: Fit,
    diagnosis: Diagnosed,
    workers: int,
    say: Callable[[str], None],
) -> tuple[Group, ...]:
    say("the mechanism with what the diagnosis names")
    plain, _ = initial_models(fit, workers=workers)
    named = _named(plain, diagnosis)
    if abs(named.over_noise / diagnosis.over_noise - 1.0) > DESIGN.same_ratio:
        raise _of_another(
            diagnosis,
            f"its mechanism leaves {named.over_noise:.4g} times the noise of these records, "
            f"not {diagnosis.over_noise:.4g} times as it says",
        )
    groups = []
    for effect in diagnosis.groups:
        models = [named]
        for alias in effect.aliases:
            say(f"{alias} in place of {effect.name} is fitted")
            models.append(_with(diagnosis, named, effect.name, alias))
        groups.append(Group((effect.name, *effect.aliases), fitted_alike(models)))
    return tuple(groups)


def fitted_alike(models: Sequence[Model]) -> tuple[Model, ...]:
    """Return rivals fitted also from where the best of them has come: one may have stopped on a wrong branch."""
    best = min(models, key=lambda model: model.cost)
    again = (model if model is best else model.fit(best) for model in models)
    return tuple(min(one, other, key=lambda model: model.cost) for one, other in zip(models, again, strict=True))


def _of_another(diagnosis: Diagnosed, why: str) -> InputFileError:
    return InputFileError(f"{diagnosis.path}: is of another campaign or fit: {why}; run mechid diagnose on this fit")


def _named(plain: Model, diagnosis: Diagnosed) -> Model:
    """Return the mechanism with all effects that a diagnosis names, at its values."""
    assert diagnosis.mechanism is not None
    model = plain
    for effect in diagnosis.effects:
        model = _widened(diagnosis, model, effect.name)
    if missing := [
        p.name for p in model.setting.problem.space.mechanism.free if p.name not in diagnosis.mechanism.parameters
    ]:
        raise _of_another(diagnosis, f"{PROPOSED_NAME} has no {missing[0]}")
    values = {name: p.value for name, p in diagnosis.mechanism.parameters.items()}
    in_library = {wide: values[here] for wide, here in _entries(model, diagnosis.mechanism).items()}
    of_records = {
        n: p.value for e in diagnosis.effects if e.name in model.disturbances for n, p in e.parameters.items()
    }
    return model.at({**values, **in_library, **of_records})


def _entries(model: Model, proposed: Mechanism) -> dict[str, str]:
    """Return the name in the proposed file of each parameter of the model's terms: there they stand alone."""
    alone = superset_of(model.base, only=model.terms, further=model.further) if model.terms else None
    if alone is None or model.library is None:
        return {}
    pairs: dict[str, str] = {}
    for term in model.terms:
        wide, here = ([n for n, t in of.items() if t == term] for of in (model.library.term_of, alone.term_of))
        pairs |= {w: h for w, h in zip(wide, here, strict=True) if h in proposed.parameters}
    return pairs


def _widened(diagnosis: Diagnosed, model: Model, effect: str) -> Model:
    """Return a model with one more effect, not fitted."""
    if model.library and effect in {t.name for t in model.library.terms}:
        return replace(model, terms=(*model.terms, effect))
    if effect in {one.name for one in model.setting.disturbances}:
        return replace(model, disturbances=(*model.disturbances, effect))
    if beyond := extension_named(model.base, effect):
        return _widened(diagnosis, model.add_candidates([beyond]), effect)
    law = next((law for law in rivals_of(model.base) if effect in (law.name, law.name.partition(":")[0])), None)
    if law is None:
        raise _of_another(diagnosis, f'"{effect}" is no effect that its mechanism or its records may have')
    return replace(model, base=law.mechanism, laws=(*model.laws, law.name))


def _with(diagnosis: Diagnosed, model: Model, effect: str, alias: str) -> Model:
    """Return a model with another effect in place of one of its terms or disturbances, fitted."""
    terms, others = (tuple(n for n in names if n != effect) for names in (model.terms, model.disturbances))
    return _widened(diagnosis, replace(model, terms=terms, disturbances=others), alias).fit(model)
