"""Diagnosis of a campaign, read from its result folder, and the mechanism that it proposes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mechid.campaign import Campaign
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.toml_file import read_toml
from mechid.errors import InputFileError
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import Disturbance, disturbed_campaign
from mechid.identification.identify import make_problem
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME, REMEDY, read_diagnosis
from mechid.identification.result.missing_effects import Missing
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.subset import nulls_of, subset_of
from mechid.plant.superset import rivals_of, words_of
from mechid.web.estimate import Estimate
from mechid.web.knobs import with_range
from mechid.web.named_effect import IN_PLACE, NO_VALUE, NamedEffect

SAME = 1e-9
"""Relative tolerance for values that were written to a file and read back."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredDiagnosis:
    """Diagnosis of a campaign.

    Attributes
    ----------
    words : str
        Overall result.
    effects : tuple of NamedEffect
    tried : sequence of mapping
        Effects that were tried but not named: ``name``, ``words``, ``why``.
    base : Mechanism
        Mechanism as written in the campaign's mechanism file.
    """

    words: str
    effects: tuple[NamedEffect, ...]
    tried: Sequence[Mapping[str, str]]
    base: Mechanism

    def effect(self, name: str) -> NamedEffect | None:
        """Return the effect with this name, None if there is none."""
        return next((one for one in self.effects if one.name == name), None)

    def remove_disabled(self, mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
        """Remove the tables of effects that are disabled at the given values."""
        on = {t for one in self.effects if one.is_on(values) for t in one.tables}
        off = {t for one in self.effects for t in one.tables} - on
        return subset_of(mechanism, self.base, off) if off else mechanism


def read_diagnosed(folder: Path, campaign: Campaign, estimate: Estimate | None) -> tuple[Campaign, StoredDiagnosis]:
    """Read a result folder of ``mechid diagnose``; return the campaign with the proposed mechanism, and the diagnosis.

    Parameters
    ----------
    folder : Path
    campaign : Campaign
        Campaign with the diagnosed mechanism.
    estimate : Estimate or None
        The diagnosed fit, whose interpretation of the records is adopted.

    Raises
    ------
    InputFileError
        A file is missing or damaged, or the diagnosis belongs to another campaign.
    """
    content = read_diagnosis(folder / FILE_NAME)
    missing: list[Missing] = content["missing"]
    base, records = campaign.mechanism, _interpret_records(campaign, estimate)
    _refuse_other_records(missing, campaign, folder / FILE_NAME)
    possibly = _disturbances(records, missing)
    if missing:
        campaign = replace(records, mechanism=_read_proposed(folder, campaign, missing))
    words = words_of(base) | {one.name: one.words for one in possibly.values()}
    effects = tuple(_effect(one, base, campaign.mechanism, possibly, words) for one in missing)
    campaign = _include_nulls(_apply_disturbances(campaign, missing, possibly), effects)
    diagnosed = StoredDiagnosis(
        words=content["unexplained"]["words"], effects=effects, tried=content["tried"], base=base
    )
    return (replace(campaign, mechanism_path=folder / PROPOSED_NAME) if missing else campaign), diagnosed


def _interpret_records(campaign: Campaign, estimate: Estimate | None) -> Campaign:
    """Interpret the records of a campaign as a fit did, and set their parameters to its values."""
    if estimate is None:
        return campaign
    own = {r.name: r for r in estimate.records}
    records = (replace(own.get(r.name, r), use=r.use) for r in campaign.records)
    values = estimate.values
    return replace(
        campaign,
        records=tuple(
            replace(r, parameters=tuple(replace(q, value=values.get(q.name, q.value)) for q in r.parameters))
            for r in records
        ),
    )


def _refuse_other_records(missing: Iterable[Missing], campaign: Campaign, path: Path) -> None:
    known = {record.name for record in campaign.records}
    other = next((name for one in missing for name in one.records if name not in known), None)
    if other is not None:
        raise InputFileError(f'{path}: names the record "{other}", which is not in {campaign.path}; {REMEDY}')


def _read_proposed(folder: Path, campaign: Campaign, missing: Sequence[Missing]) -> Mechanism:
    """Read the proposed mechanism; without its effects it has to equal that of the campaign."""
    path, base = folder / PROPOSED_NAME, campaign.mechanism
    if not path.is_file():
        raise InputFileError(f"{path}: there is no such file; {REMEDY}")
    proposed = mechanism_from_table(read_toml(path, "mechanism"), path.name, campaign.mechanism_path.parent)
    outputs = tuple(base.plant.outputs)
    if outputs != tuple(proposed.plant.outputs):
        proposed = replace(proposed, plant=proposed.plant.with_outputs(outputs))
    wrong = _difference(proposed, base, {name for one in missing if one.block for name in one.parameters})
    if wrong:
        raise InputFileError(f"{path}: is not of {campaign.mechanism_path}: {wrong}; {REMEDY}")
    return proposed


def _difference(proposed: Mechanism, base: Mechanism, own: set[str]) -> str:
    """Describe a difference between the proposed and the written mechanism apart from the effects; empty if none."""
    absent = [name for name in (*base.parameters, *own) if name not in proposed.parameters]
    if absent:
        return f"it lacks {absent[0]}"
    if proposed.options.get("assembly") != base.options.get("assembly"):
        return "it is another assembly"
    less = subset_of(proposed, base, {name.rpartition(".")[0] for name in own})
    other = [*(less.parameters.keys() ^ base.parameters.keys()), *(dict(less.options.items() ^ base.options.items()))]
    if other:
        return f"{other[0]} is in one of them only"
    for name, q in base.parameters.items():
        # Free parameters are skipped: the fit has changed them.
        if not q.is_free and not math.isclose(less.value(name), base.value(name), rel_tol=SAME) and not q.tied_to:
            return f"{name} is {less.value(name):.9g} there and {base.value(name):.9g} here"
    return ""


def _disturbances(campaign: Campaign, missing: Iterable[Missing]) -> dict[str, Disturbance]:
    """Return the missing disturbances that have parameters, by name, at their null values."""
    names = {one.name for one in missing if not one.block}
    if not names:
        return {}
    found = possible_disturbances(make_problem(campaign, 1), campaign)
    return {one.name: one for one in found if one.name in names and one.parameters}


def _effect(
    one: Missing, base: Mechanism, mechanism: Mechanism, possibly: Mapping[str, Disturbance], words: Mapping[str, str]
) -> NamedEffect:
    found = {name: p.value for name, p in one.parameters.items()}
    aliases = {name: words.get(name, "") for name in one.aliases}
    effect = NamedEffect(name=one.name, words=one.words, share=one.share, aliases=aliases, found=found)
    if not one.block:
        return _of_records(effect, possibly.get(one.name))
    free = frozenset(name for name in found if mechanism.parameters[name].is_free)
    nulls = _nulls(one, base, mechanism)
    return replace(effect, nulls=nulls, free=free, why_fixed="" if nulls else IN_PLACE)


def _of_records(effect: NamedEffect, disturbance: Disturbance | None) -> NamedEffect:
    """Complete an effect of the records; it has no switch if the page cannot apply it."""
    own = {p.name: p for p in disturbance.parameters} if disturbance else {}
    if not effect.found.keys() <= own.keys():
        return replace(effect, is_of_records=True, why_fixed=NO_VALUE)
    return replace(
        effect,
        is_of_records=True,
        nulls={name: own[name].value for name in effect.found},
        follows={name: own[name].replaces for name in effect.found if own[name].replaces},
        free=frozenset(effect.found),
    )


def _nulls(one: Missing, base: Mechanism, mechanism: Mechanism) -> dict[str, float]:
    """Return the null values of an effect: the amplitude of a law, or all parameters of a term except phases."""
    law = next((law for law in rivals_of(base) if law.entry_name == one.name), None)
    if law is None:
        return nulls_of(mechanism, one.parameters)
    return {law.null: 0.0} if law.null else {}


def _apply_disturbances(
    campaign: Campaign, missing: Iterable[Missing], possibly: Mapping[str, Disturbance]
) -> Campaign:
    """Apply the found disturbances to the records, with the bounds of the overridden parameters."""
    found = {name: p.value for one in missing for name, p in one.parameters.items()}
    known = campaign.mechanism.parameters

    def widen(p: Parameter) -> Parameter:
        ends = with_range(known[p.replaces]) if p.replaces else p
        return replace(p, value=found[p.name], min=min(p.min, ends.min), max=max(p.max, ends.max))

    here = [
        replace(one, own={r: tuple(widen(p) for p in own if p.name in found) for r, own in one.own.items()})
        for one in possibly.values()
    ]
    return disturbed_campaign(campaign, here)


def _include_nulls(campaign: Campaign, effects: Iterable[NamedEffect]) -> Campaign:
    """Extend the bounds of the effects' parameters to include their null values."""
    own = campaign.mechanism.parameters
    nulls = {name: null for one in effects for name, null in one.nulls.items() if name in own and own[name].is_free}
    wide = {n: replace(own[n], min=min(own[n].min, null), max=max(own[n].max, null)) for n, null in nulls.items()}
    return replace(campaign, mechanism=campaign.mechanism.with_parameters(wide))
