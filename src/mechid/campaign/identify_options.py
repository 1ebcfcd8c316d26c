"""The ``[identify]`` table of a campaign file: what the user decides of the estimation itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from mechid.campaign.place import Place, above_zero, flag, found, one_of, refuse_unknown_keys
from mechid.command.entry import is_table, quote_words
from mechid.signal.settings import HUM

Priors: TypeAlias = Literal["fit", "search", "none"]
Colour: TypeAlias = Literal["auto", "prefilter", "none"]
Spikes: TypeAlias = Literal["keep", "reject"]
Disturbances: TypeAlias = Literal["auto", "none"] | tuple[str, ...]
CHOICES = {"priors": ("fit", "search", "none"), "colour": ("auto", "prefilter", "none"), "spikes": ("keep", "reject")}
MAINS, WANDER = "mains", 0.01
DISTURBANCES = (MAINS, "clock", "record.clock", "record.delay", "record.voltage", "record.gain", "record.temperature")
"""What records may have beside the mechanism, as estimate.json names it."""
LIMITS = ("max_relative_error", "max_correlation")


@dataclass(frozen=True, kw_only=True)
class IdentifyOptions:
    """How the estimation treats priors, colour, spikes and dependent parameters.

    Parameters
    ----------
    priors : {"fit", "search", "none"}
        Whether the `sigma` of parameters counts throughout, only until the last fit, or not at all.
    colour : {"auto", "prefilter", "none"}
        Whether coloured residuals are whitened by an autoregressive prefilter: where they are no larger than the
        record's noise floor allows, always, or never. The covariance allows for colour in each case.
    spikes : {"keep", "reject"}
        Whether single samples far off the rest count.
    freeze : bool
        Whether a parameter is frozen where a dependence ruins the estimate.
    max_relative_error : float or None
        Standard error over value above which a parameter counts as ruined.
    max_correlation : float or None
        Magnitude of a correlation above which two parameters count as dependent.
    disturbances : "auto", "none" or tuple of str
        Which of `DISTURBANCES` may be added where the records ask for them: all, none, or those named.
    terms : bool
        Whether terms and laws may be added to the mechanism where it does not follow the records as written.
    mains : float or None
        Frequency of the mains in Hz, whose hum is projected out of all records from the start; 50 or 60 are nominal,
        and what it was is seen in the records.
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
    """Return the options of a campaign file, the defaults where it has none.

    Raises
    ------
    InputFileError
        A key or its entry is not one of those known.
    """
    entry, here = table.get("identify", {}), place.key("identify")
    if not is_table(entry):
        raise here.error(f"{found(entry)}; write a table, [identify]")
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
            options[key] = above_zero(value, here.key(key), "1")
        else:
            options[key] = flag(value, here.key(key))
    return IdentifyOptions(**options)


def _disturbances(entry: Any, place: Place) -> Disturbances:
    if isinstance(entry, list):
        return tuple(one_of(name, DISTURBANCES, place.item(index)) for index, name in enumerate(entry))
    if entry not in ("auto", "none"):
        raise place.error(f'{found(entry)}; write "auto", "none", or a list of some of {quote_words(DISTURBANCES)}')
    return "none" if entry == "none" else "auto"


def _mains(entry: Any, place: Place) -> float:
    hz = above_zero(entry, place, "Hz")
    if min(abs(hz / grid - 1.0) for grid in HUM.mains_hz) > WANDER:
        grids = " or ".join(f"{grid:g}" for grid in HUM.mains_hz)
        raise place.error(f"found {hz:.9g}; write {grids}, or the mains' own frequency within 1 % of it, in Hz")
    return hz
