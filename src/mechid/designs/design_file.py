"""Reader of design.toml: noise and durations, candidates, limits, criterion; every key has a default."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mechid.campaign.place import (
    Place,
    above_zero,
    found,
    not_below_zero,
    number,
    one_of,
    refuse_unknown_keys,
    text,
    texts,
)
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table, is_whole
from mechid.command.stepping import MOST_MICROSTEPS, STEPPINGS, Stepping
from mechid.designs.candidates import CandidateChoice
from mechid.designs.criterion import OVER
from mechid.designs.planned_record import Recording

FILE_NAME = "design.toml"
KEYS = ("seed", "recording", "candidates", "limits", "criterion", "prior")
RECORDING_KEYS = ("noise_Nm", "sample_rate_hz", "duration_s", "durations_s")
CANDIDATE_KEYS = (
    "steppings",
    "microsteps",
    "rates",
    "start_angles_deg",
    "durations_s",
    "sweeps_s",
    "sweep_to",
)
LIMIT_KEYS = ("total_s", "between_s", "torque_Nm", "most_of_one", "keep", "risk", "departing")
CRITERION_KEYS = ("kind", "over")
PRIOR_KEYS = ("mechanisms",)
NUMBERS_REMEDY = "write numbers, such as [23.0, 46.0]"
MOST_MECHANISMS = 1024


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Constraints of a design.

    Parameters
    ----------
    total_s : float or None
        Test time, including the time between records; None is that of the campaign's own records.
    between_s : float
        Time from the end of a record to the start of the next.
    torque_Nm : float or None
        Range of the transducer.
    most_of_one : int
        Largest number of repetitions of one record.
    keep : tuple of str
        Records of the campaign that are always taken.
    risk : float
        Share of the prior's mechanisms that may lose steps in a record, or exceed the range.
    departing : float
        Share of draws in which a record may be less informative than its derivatives predict because a stick-slip event
        changes.
    """

    total_s: float | None = None
    between_s: float = 10.0
    torque_Nm: float | None = None
    most_of_one: int = 1
    keep: tuple[str, ...] = ()
    risk: float = 0.2
    departing: float = 0.1


@dataclass(frozen=True, kw_only=True)
class DesignOptions:
    """Content of a design file.

    Parameters
    ----------
    seed : int
        Seed of the prior's mechanisms.
    criterion : str
        ``"D"``, ``"A"``, ``"E"`` or a parameter's name.
    over : {"mean", "low"}
    mechanisms : int
        Number of mechanisms in the prior, the file's own values included.
    """

    seed: int = 0
    recording: Recording = field(default_factory=Recording)
    candidates: CandidateChoice = field(default_factory=CandidateChoice)
    limits: Limits = field(default_factory=Limits)
    criterion: str = "D"
    over: str = "mean"
    mechanisms: int = 16

    def with_overrides(self, criterion: str | None, total_s: float | None) -> DesignOptions:
        """Return the options with values of a command line in their place."""
        limits = replace(self.limits, total_s=total_s) if total_s else self.limits
        return replace(self, limits=limits, criterion=criterion or self.criterion)


def options_for(campaign: Path) -> DesignOptions:
    """Return the options of the design file in a campaign file's folder, or the defaults without one."""
    path = campaign.parent / FILE_NAME
    return read_design_file(path) if path.is_file() else DesignOptions()


def read_design_file(path: Path | str) -> DesignOptions:
    """Read a design file.

    Raises
    ------
    InputFileError
        The file is missing or wrong; the message is one line with place, value found and remedy.
    """
    path = Path(path)
    table, place = read_toml(path), Place(path.name)
    refuse_unknown_keys(table, KEYS, place)
    criterion, at = _table(table, "criterion", CRITERION_KEYS, place)
    prior, prior_at = _table(table, "prior", PRIOR_KEYS, place)
    return DesignOptions(
        seed=_whole_number(table, "seed", 0, place, least=0, most=2**32),
        recording=_read_recording(*_table(table, "recording", RECORDING_KEYS, place)),
        candidates=_candidates(*_table(table, "candidates", CANDIDATE_KEYS, place)),
        limits=_limits(*_table(table, "limits", LIMIT_KEYS, place)),
        criterion=text(criterion.get("kind", "D"), at.key("kind"), 'write "D", "A", "E" or the name of a parameter'),
        over=one_of(criterion.get("over", OVER[0]), OVER, at.key("over")),
        mechanisms=_whole_number(prior, "mechanisms", 16, prior_at, least=1, most=MOST_MECHANISMS),
    )


def _read_recording(table: Mapping[str, Any], place: Place) -> Recording:
    own = table.get("durations_s", {})
    if not is_table(own):
        raise place.key("durations_s").error(f"{found(own)}; write a table, as {{ full_46 = 2.0 }}")
    at = place.key("durations_s")
    return Recording(
        noise_Nm=_positive_or_none(table, "noise_Nm", place, "N m"),
        sample_rate_hz=_positive_or_none(table, "sample_rate_hz", place, "Hz"),
        duration_s=_positive_or_none(table, "duration_s", place, "s") or 1.0,
        durations_s={name: above_zero(value, at.key(name), "s") for name, value in own.items()},
    )


def _candidates(table: Mapping[str, Any], place: Place) -> CandidateChoice:
    plain = CandidateChoice()
    return CandidateChoice(
        steppings=_steppings(table.get("steppings", list(STEPPINGS)), place.key("steppings")),
        microsteps=_whole_number(table, "microsteps", plain.microsteps, place, least=1, most=MOST_MICROSTEPS),
        rates=_numbers(table, "rates", plain.rates, place, positive=True),
        start_angles_deg=_numbers(table, "start_angles_deg", plain.start_angles_deg, place),
        durations_s=_numbers(table, "durations_s", plain.durations_s, place, positive=True),
        sweeps_s=_numbers(table, "sweeps_s", plain.sweeps_s, place, positive=True),
        sweep_to=_positive_or_none(table, "sweep_to", place, "full steps/s"),
    )


def _steppings(entry: Any, place: Place) -> tuple[Stepping, ...]:
    requested = texts(entry, place, 'write steppings, as ["full", "micro"]')
    for k, word in enumerate(requested):
        one_of(word, STEPPINGS, place.item(k))
    return tuple(s for s in STEPPINGS if s in requested)


def _limits(table: Mapping[str, Any], place: Place) -> Limits:
    plain = Limits()
    kept = table.get("keep", [])
    return Limits(
        total_s=_positive_or_none(table, "total_s", place, "s"),
        between_s=not_below_zero(table.get("between_s", plain.between_s), place.key("between_s"), "s"),
        torque_Nm=_positive_or_none(table, "torque_Nm", place, "N m"),
        most_of_one=_whole_number(table, "most_of_one", plain.most_of_one, place, least=1, most=100),
        keep=texts(kept, place.key("keep"), 'write names of records, as ["full_46"]') if kept else (),
        risk=_share(table, "risk", plain.risk, place),
        departing=_share(table, "departing", plain.departing, place),
    )


def _share(table: Mapping[str, Any], key: str, default: float, place: Place) -> float:
    value = number(table.get(key, default), place.key(key), "1")
    if not 0.0 <= value <= 1.0:
        raise place.key(key).error(f"found {value:.9g}; write a share from 0 to 1")
    return value


def _table(table: Mapping[str, Any], key: str, known: Sequence[str], place: Place) -> tuple[Mapping[str, Any], Place]:
    entry, at = table.get(key, {}), place.key(key)
    if not is_table(entry):
        raise at.error(f"{found(entry)}; write a table [{key}]")
    refuse_unknown_keys(entry, known, at)
    return entry, at


def _numbers(
    table: Mapping[str, Any], key: str, default: tuple[float, ...], place: Place, *, positive: bool = False
) -> tuple[float, ...]:
    if key not in table:
        return default
    entry, at = table[key], place.key(key)
    if not isinstance(entry, list):
        raise at.error(f"{found(entry)}; {NUMBERS_REMEDY}")
    values = [above_zero(v, at.item(k), "1") if positive else number(v, at.item(k), "1") for k, v in enumerate(entry)]
    return tuple(dict.fromkeys(values))


def _positive_or_none(table: Mapping[str, Any], key: str, place: Place, unit: str) -> float | None:
    return above_zero(table[key], place.key(key), unit) if key in table else None


def _whole_number(table: Mapping[str, Any], key: str, default: int, place: Place, *, least: int, most: int) -> int:
    value = table.get(key, default)
    if not is_whole(value, least, most):
        raise place.key(key).error(f"{found(value)}; write a whole number from {least} to {most}")
    return int(value)
