"""Effects that the data support and the files do not declare: entries of ``missing`` in estimate.json."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Protocol, Self

import numpy as np
from scipy.special import chdtrc

from mechid.campaign.campaign import CAMPAIGN, record_parameter_name
from mechid.identification.effects.disturbance import Disturbance, FoundDisturbance
from mechid.identification.result.settings import GRADE
from mechid.signal.grid import combined_amplitude


@dataclass(frozen=True, kw_only=True)
class EffectValue:
    """A parameter's value and standard error, None where it has none, in its unit."""

    value: float
    std_error: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class Missing:
    """An effect that the files do not declare.

    Attributes
    ----------
    name : str
        Such as ``"clock"`` or ``"record.voltage"``.
    words : str
        Description of the effect.
    parameters : mapping of dotted name to EffectValue
    chi_square : float
        Fall of the sum of squares by the effect, by each record's effective sample count.
    dof : int
    share : float
        Explained share of the records' misfit beyond noise.
    p_value : float
        Probability of such a fall, or a larger one, by noise.
    records : tuple of str
        Records that show the effect.
    toml : str
        Declaration to append to the campaign file, or to the mechanism file for a term or law.
    block : str
        Table of the mechanism file for a term or law; empty for a disturbance of the records.
    aliases : tuple of str
        Effects that explain the records equally well.
    """

    name: str
    words: str
    parameters: Mapping[str, EffectValue]
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
        """Read an entry of estimate.json."""
        lists = {key: tuple(own[key]) for key in ("records", "aliases")}
        parameters = {name: EffectValue(**p) for name, p in own["parameters"].items()}
        return cls(**{**own, **lists, "parameters": parameters})


@dataclass(frozen=True, kw_only=True)
class SuggestedEffect:
    """An effect that the residual of a fit suggests by the derivative alone; no fit has tested it.

    Attributes
    ----------
    name, words : str
    chi_square, p_value : float
    dof : int
        As in `Missing`.
    share : float
        Explained share of the remaining sum of squares.
    """

    name: str
    words: str
    chi_square: float
    dof: int
    share: float
    p_value: float


class ChannelWithLines(Protocol):
    """A fitted channel: the removed lines, each with frequency in Hz, amplitude and phase, and its unit."""

    @property
    def lines(self) -> tuple[tuple[float, float, float], ...]: ...  # noqa: D102

    @property
    def unit(self) -> str: ...  # noqa: D102


class RecordWithLines(Protocol):
    """A fitted record, its leading channel first."""

    @property
    def channels(self) -> Mapping[str, ChannelWithLines]: ...  # noqa: D102

    @property
    def residual_rms(self) -> float: ...  # noqa: D102

    @property
    def samples(self) -> int: ...  # noqa: D102


def missing_entry(
    found: FoundDisturbance, values: Mapping[str, EffectValue], records: Mapping[str, RecordWithLines]
) -> Missing:
    """Return the entry of a disturbance that was added to a fit, with its estimated values.

    For mains hum these are the grid's frequency and the amplitude of each line in each record.
    """
    one = found.disturbance
    own = {p.name: values[p.name] for p in one.parameters} | _hum_values(one, records)
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


def _hum_values(one: Disturbance, records: Mapping[str, RecordWithLines]) -> dict[str, EffectValue]:
    """Return the estimated values of mains hum by dotted name; empty for other disturbances."""
    grid_hz, seen_hz = one.mains_hz, one.seen_hz
    if grid_hz is None or seen_hz is None:
        return {}
    own = {f"{CAMPAIGN}.mains_hz": EffectValue(value=seen_hz, std_error=None, unit="Hz")}
    for name, lines in one.lines_hz.items():
        multiples = sorted({round(hz / grid_hz) for hz in lines})
        for multiple, amplitude in ((k, _amplitude_near(records[name], k * grid_hz)) for k in multiples):
            if amplitude is not None:
                own[record_parameter_name(name, f"mains_{multiple}")] = amplitude
    return own


def _amplitude_near(record: RecordWithLines, hz: float) -> EffectValue | None:
    """Return the amplitude of the lines at one multiple of the grid frequency; None where there is no line.

    Several lines describe a slow drift; their amplitude is that of one sine of the same power.
    """
    channel = next(iter(record.channels.values()), None)
    near = [line for line in (channel.lines if channel else ()) if abs(line[0] / hz - 1.0) < GRADE.near_multiple]
    if channel is None or not near:
        return None
    # Standard error of a sine's amplitude in white noise, fitted to N samples: sigma sqrt(2 / N).
    error = record.residual_rms * math.sqrt(2.0 / max(record.samples, 1))
    return EffectValue(value=combined_amplitude(near), std_error=error, unit=channel.unit)


def missing_warning(missing: Missing) -> str:
    """Describe an effect that was added to a fit, and how to declare or to exclude it."""
    values = [f"{name} = {_format_value(p)}" for name, p in missing.parameters.items()]
    found = ", ".join([*values[: GRADE.most_named], "..."] if len(values) > GRADE.most_named else values)
    where = "its declaration is in missing of estimate.json"
    option = 'disturbances = "none"'
    # A term or law of the mechanism; disturbances have no block.
    if missing.block:
        where, option = f"{where} and in the mechanism file beside it", "terms = false"
    return (
        f"{missing.name}: {missing.words}, which the data support and the files do not declare (chi-square "
        f"{missing.chi_square:.4g} for {missing.dof}, {100.0 * missing.share:.3g} % of the misfit beyond noise): it is "
        f"estimated with the rest, {found}{_common_error(missing)}; {where}; write {option} in [identify] to exclude it"
    )


def _common_error(missing: Missing) -> str:
    """Estimate the common error of per-record values whose mean is fixed; empty where the mean is free."""
    # One degree of freedom fewer than values: the mean of the values is tied to the mechanism's value.
    values = [p.value for p in missing.parameters.values()]
    if len(values) - missing.dof != 1 or not np.mean(values):
        return ""
    scatter = 100.0 * float(np.std(values, ddof=1) / abs(np.mean(values)))
    return (
        f" (their mean is taken as the mechanism's value; they scatter by {scatter:.2g} %, so it may have an "
        f"undetected error of {scatter / math.sqrt(len(values)):.2g} %, which the standard errors include)"
    )


def _format_value(p: EffectValue) -> str:
    error = f" +- {p.std_error:.2g}" if p.std_error is not None else ""
    return f"{p.value:.6g}{error} {p.unit}".removesuffix(" 1")


@dataclass(frozen=True, kw_only=True)
class AsWritten:
    """Prediction of the records by the mechanism as written, at the values of the fit with added terms.

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
        """Read an entry of estimate.json; null stands for a ratio that is not a number."""
        ratios = {name: float("nan") if r is None else float(r) for name, r in entry["residual_over_noise"].items()}
        return cls(follows=bool(entry["follows"]), residual_over_noise=ratios)
