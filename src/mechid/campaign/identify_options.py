"""``[identify]`` table of a campaign file: options of the estimation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from mechid.campaign.place import Place, describe_entry, flag, one_of, positive_number, refuse_unknown_keys
from mechid.command.entry import is_table, quote_words
from mechid.signal.settings import HUM

Priors: TypeAlias = Literal["fit", "search", "none"]
Colour: TypeAlias = Literal["auto", "prefilter", "none"]
Spikes: TypeAlias = Literal["keep", "reject"]
Disturbances: TypeAlias = Literal["auto", "none"] | tuple[str, ...]
CHOICES = {"priors": ("fit", "search", "none"), "colour": ("auto", "prefilter", "none"), "spikes": ("keep", "reject")}
MAINS, WANDER = "mains", 0.01
ONE_CLOCK = "clock"
"""Rate of the recorder's clock against the driver's, one for all records."""
DISTURBANCES = (MAINS, ONE_CLOCK, "record.clock", "record.delay", "record.voltage", "record.gain", "record.temperature")
"""Disturbances of records besides the mechanism, as named in estimate.json."""
LIMITS = ("max_relative_error", "max_correlation")


@dataclass(frozen=True, kw_only=True)
class IdentifyOptions:
    """Treatment of priors, noise colour, spikes and dependent parameters.

    Parameters
    ----------
    priors : {"fit", "search", "none"}
        Whether priors (the `sigma` of parameters) apply throughout, in all but the last fit, or not at all.
    colour : {"auto", "prefilter", "none"}
        Whether an autoregressive prefilter whitens coloured residuals: if they are no larger than the record's
        noise floor allows, always, or never. The covariance accounts for colour in each case.
    spikes : {"keep", "reject"}
        Whether single outlying samples are kept or rejected.
    freeze : bool
        Whether a parameter is frozen if a dependence makes the estimate useless.
    max_relative_error : float or None
        Relative standard error above which a parameter counts as not estimated.
    max_correlation : float or None
        Magnitude of a correlation above which two parameters count as dependent.
    disturbances : "auto", "none" or tuple of str
        Which of `DISTURBANCES` may be added if the data support them: all, none, or those named.
    terms : bool
        Whether terms and laws may be added to the mechanism if the model as written does not fit the records.
    mains : float or None
        Mains frequency in Hz, whose hum is projected out of all records from the start; 50 or 60 are nominal, and
        the actual frequency is estimated from the records.
    """

    priors: Priors = "fit"
    colour: Colour = "auto"
    spikes: Spikes = "keep"
    freeze: bool = True
    max_relative_error: float | None = None
    max_correlation: float | None = None
    disturbances: Disturbances = "auto"
    terms: bool = True
    mains: float | None = None


KEYS = tuple(IdentifyOptions.__dataclass_fields__)


def read_identify_options(table: Mapping[str, Any], place: Place) -> IdentifyOptions:
    """Read the options of a campaign file, with defaults for missing keys.

    Raises
    ------
    InputFileError
        A key or a value is unknown.
    """
    entry, here = table.get("identify", {}), place.key("identify")
    if not is_table(entry):
        raise here.error(f"{describe_entry(entry)}; write a table, [identify]")
    refuse_unknown_keys(entry, KEYS, here)
    options: dict[str, Any] = {}
    for key, value in entry.items():
        if key in CHOICES:
            options[key] = one_of(value, CHOICES[key], here.key(key))
        elif key == "disturbances":
            options[key] = _disturbances(value, here.key(key))
        elif key == MAINS:
            options[key] = _mains(value, here.key(key))
        elif key in LIMITS:
            options[key] = positive_number(value, here.key(key), "1")
        else:
            options[key] = flag(value, here.key(key))
    return IdentifyOptions(**options)


def _disturbances(entry: Any, place: Place) -> Disturbances:
    if isinstance(entry, list):
        return tuple(one_of(name, DISTURBANCES, place.item(index)) for index, name in enumerate(entry))
    if entry not in ("auto", "none"):
        raise place.error(
            f'{describe_entry(entry)}; write "auto", "none", or a list of some of {quote_words(DISTURBANCES)}'
        )
    return "none" if entry == "none" else "auto"


def _mains(entry: Any, place: Place) -> float:
    hz = positive_number(entry, place, "Hz")
    # Grids stay within 1 % of their nominal frequency; other numbers are typing errors.
    if min(abs(hz / grid - 1.0) for grid in HUM.mains_hz) > WANDER:
        grids = " or ".join(f"{grid:g}" for grid in HUM.mains_hz)
        raise place.error(f"found {hz:.9g}; write {grids}, or the mains' own frequency within 1 % of it, in Hz")
    return hz
