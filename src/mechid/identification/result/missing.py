"""Effects that the files do not declare and the records ask for: entries of ``missing`` in estimate.json."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Protocol, Self

import numpy as np
from scipy.special import chdtrc

from mechid.campaign.campaign import CAMPAIGN, record_parameter_name
from mechid.identification.effects.disturbance import Disturbance, Found
from mechid.identification.result.settings import GRADE
from mechid.signal.grid import combined_amplitude


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
        Text that declares it at the end of the campaign file, or for a term or law at the end of the mechanism file.
    block : str
        Table of the mechanism file that holds it; empty for a disturbance of the records.
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


@dataclass(frozen=True, kw_only=True)
class Suggested:
    """An effect that what a fit leaves asks for by its derivative alone; no fit has tested it.

    Attributes
    ----------
    name, words : str
    chi_square, p_value : float
    dof : int
        As of `Missing`.
    share : float
        Of the sum of squares that is left.
    """

    name: str
    words: str
    chi_square: float
    dof: int
    share: float
    p_value: float


class HummedChannel(Protocol):
    """A channel as it was fitted: its lines removed, each with frequency in Hz, amplitude and phase, and its unit."""

    @property
    def lines(self) -> tuple[tuple[float, float, float], ...]: ...  # noqa: D102

    @property
    def unit(self) -> str: ...  # noqa: D102


class HummedRecord(Protocol):
    """A record as it was fitted, its leading channel first."""

    @property
    def channels(self) -> Mapping[str, HummedChannel]: ...  # noqa: D102

    @property
    def residual_rms(self) -> float: ...  # noqa: D102

    @property
    def samples(self) -> int: ...  # noqa: D102


def missing_of(found: Found, values: Mapping[str, OwnValue], records: Mapping[str, HummedRecord]) -> Missing:
    """Return the entry of a disturbance that was put into a fit, with the values that the fit gives it.

    Of mains hum these are the grid's frequency and the amplitude of each line in each record.
    """
    one = found.disturbance
    own = {p.name: values[p.name] for p in one.parameters} | _hum(one, records)
    return Missing(
        name=one.name,
        words=one.words,
        parameters=own,
        chi_square=found.chi_square,
        dof=one.dof,
        share=found.share,
        p_value=float(chdtrc(one.dof, found.chi_square)),
        records=one.records,
        toml=one.toml({name: p.value for name, p in own.items()}),
    )


def _hum(one: Disturbance, records: Mapping[str, HummedRecord]) -> dict[str, OwnValue]:
    """Return what a fit gives of mains hum, by dotted name; nothing of other disturbances."""
    grid_hz, seen_hz = one.mains_hz, one.seen_hz
    if grid_hz is None or seen_hz is None:
        return {}
    own = {f"{CAMPAIGN}.mains_hz": OwnValue(value=seen_hz, std_error=None, unit="Hz")}
    for name, lines in one.lines_hz.items():
        multiples = sorted({round(hz / grid_hz) for hz in lines})
        for multiple, amplitude in ((k, _amplitude_near(records[name], k * grid_hz)) for k in multiples):
            if amplitude is not None:
                own[record_parameter_name(name, f"mains_{multiple}")] = amplitude
    return own


def _amplitude_near(record: HummedRecord, hz: float) -> OwnValue | None:
    """Return the amplitude of the lines of one multiple of the grid; None where there is none.

    Of several lines, which follow a slow drift, it is that of one sine of the same power.
    """
    channel = next(iter(record.channels.values()), None)
    near = [line for line in (channel.lines if channel else ()) if abs(line[0] / hz - 1.0) < GRADE.near_multiple]
    if channel is None or not near:
        return None
    error = record.residual_rms * math.sqrt(2.0 / max(record.samples, 1))
    return OwnValue(value=combined_amplitude(near), std_error=error, unit=channel.unit)


def missing_warning(missing: Missing) -> str:
    """Say what was added to a fit, and how to declare it or to keep it out."""
    values = [f"{name} = {_with_error(p)}" for name, p in missing.parameters.items()]
    found = ", ".join([*values[: GRADE.most_named], "..."] if len(values) > GRADE.most_named else values)
    where = "what declares it is in missing of estimate.json"
    option = 'disturbances = "none"'
    if missing.block:  # a term or law of the mechanism
        where, option = f"{where} and in the mechanism file beside it", "terms = false"
    return (
        f"{missing.name}: {missing.words}, which the files do not say and the records ask for (chi-square "
        f"{missing.chi_square:.4g} for {missing.dof}, {100.0 * missing.share:.3g} % of what is beyond noise): it is "
        f"estimated with the rest, {found}{_common(missing)}; {where}, and [identify] {option} keeps it out"
    )


def _common(missing: Missing) -> str:
    """Say what a common part of values that have a mean would be, which no record shows."""
    values = [p.value for p in missing.parameters.values()]
    if len(values) - missing.dof != 1 or not np.mean(values):
        return ""
    scatter = 100.0 * float(np.std(values, ddof=1) / abs(np.mean(values)))
    return (
        f" (their mean counts as the mechanism's value: they scatter by {scatter:.2g} %, so that it may well be "
        f"{scatter / math.sqrt(len(values)):.2g} % off, unseen, which the standard errors count)"
    )


def _with_error(p: OwnValue) -> str:
    error = f" +- {p.std_error:.2g}" if p.std_error is not None else ""
    return f"{p.value:.6g}{error} {p.unit}".removesuffix(" 1")


@dataclass(frozen=True, kw_only=True)
class AsWritten:
    """How the mechanism as written predicts the records, at the values of the fit that has further terms.

    Attributes
    ----------
    follows : bool
        Whether it follows all records that were fitted to their ends.
    residual_over_noise : mapping of record to float
        RMS of the residual over the noise known before the fit, of the leading channel.
    """

    follows: bool
    residual_over_noise: Mapping[str, float]

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        return {"follows": self.follows, "residual_over_noise": dict(self.residual_over_noise)}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what an entry of estimate.json says; null stands for a ratio that is no number."""
        ratios = {name: float("nan") if r is None else float(r) for name, r in entry["residual_over_noise"].items()}
        return cls(follows=bool(entry["follows"]), residual_over_noise=ratios)
