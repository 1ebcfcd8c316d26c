"""What the files do not declare and the records ask for: one entry of ``missing`` in estimate.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from scipy.stats import chi2

from mechid.identification.disturbance.declared import declared_toml
from mechid.identification.disturbance.disturbance import Found


@dataclass(frozen=True, kw_only=True)
class OwnValue:
    """A parameter's value and standard error, None where it has none, in its unit."""

    value: float
    std_error: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class Missing:
    """What the files lack.

    Attributes
    ----------
    name : str
        As ``"clock"`` or ``"record.voltage"``.
    words : str
        What it is.
    parameters : mapping of dotted name to OwnValue
    chi_square : float
        By how much the sum of squares falls with it, each record's samples counted for what they are worth.
    dof : int
    share : float
        Of what the records hold beyond their noise.
    p_value : float
        Chance of such a fall, or a larger one, from noise.
    records : tuple of str
        Those it is in.
    toml : str
        What declares it, where it is written below all else in the campaign file.
    block : str
        The block that holds it; empty of what is none of the mechanism.
    aliases : tuple of str
        What explains the same as well.
    """

    name: str
    words: str
    parameters: Mapping[str, OwnValue]
    chi_square: float
    dof: int
    share: float
    p_value: float
    records: tuple[str, ...]
    toml: str
    block: str = ""
    aliases: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        lists = {"records": list(self.records), "aliases": list(self.aliases)}
        return {**asdict(self), **lists}

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Missing:
        """Return what `to_dict` wrote down."""
        lists = {key: tuple(own[key]) for key in ("records", "aliases")}
        parameters = {name: OwnValue(**p) for name, p in own["parameters"].items()}
        return cls(**{**own, **lists, "parameters": parameters})


def missing_of(found: Found, values: Mapping[str, OwnValue]) -> Missing:
    """Return the entry of a disturbance that was put into a fit, with the values that the fit gives it."""
    one = found.disturbance
    own = {p.name: values[p.name] for p in one.parameters}
    return Missing(
        name=one.name, words=one.words, parameters=own, chi_square=found.chi_square, dof=one.dof, share=found.share,
        p_value=float(chi2.sf(found.chi_square, one.dof)), records=one.records,
        toml=declared_toml(one, {name: p.value for name, p in own.items()}),
    )  # fmt: skip


def missing_warning(missing: Missing) -> str:
    """Say what was put into a fit, and how to declare it or to keep it out."""
    found = ", ".join(f"{name} = {_with_error(p)}" for name, p in missing.parameters.items())
    return (
        f"{missing.name}: {missing.words}, which the files do not say and the records ask for (chi-square "
        f"{missing.chi_square:.4g} for {missing.dof}, {100.0 * missing.share:.3g} % of what is beyond noise): it is "
        f"estimated with the rest, {found}; what declares it is in missing of estimate.json, and "
        '[identify] disturbances = "none" keeps it out'
    )


def _with_error(p: OwnValue) -> str:
    error = f" +- {p.std_error:.2g}" if p.std_error is not None else ""
    return f"{p.value:.6g}{error} {p.unit}"
