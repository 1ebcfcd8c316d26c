"""Reader of fleet.toml, and of campaign folders given without such a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

from mechid.analysis.hypothesis import short_names
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.campaign.place import (
    Place,
    describe_entry,
    number,
    refuse_unknown_keys,
    required_entry,
    tables,
    text,
    texts,
)
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table, quote_words
from mechid.errors import InputFileError, UsageError
from mechid.fleets.members import Covariate, Member, Members
from mechid.fleets.significance import RATE
from mechid.identification.result.fit import ESTIMATE_NAME
from mechid.reading.whole import is_file, is_folder, is_there

FILE_NAME = "fleet.toml"
KEYS = ("campaign", "before_after", "false_discovery_rate")
CAMPAIGN_KEYS = ("folder", "label", "unit", "group", "state", "covariates")
FOLDER_REMEDY = 'write the folder of a campaign, as folder = "FM1"'
PAIR_REMEDY = 'write pairs of states, as [["before vibration", "after vibration"]]'
STATE_REMEDY = "give each of them its own state"


def read_members(sources: Sequence[Path | str]) -> Members:
    """Return the campaigns of a fleet.

    Parameters
    ----------
    sources : sequence of Path
        Fleet file or its folder, at most one; campaign files, their folders, result folders of `mechid identify`. A
        source that the fleet file also names counts once.

    Raises
    ------
    UsageError
        Nothing is given, or more than one fleet file.
    InputFileError
        A file or folder is missing, or the fleet file is wrong.
    """
    paths = [Path(source) for source in sources]
    files = [file for file in map(_fleet_file, paths) if file is not None]
    if len(files) > 1:
        raise UsageError(f"fleet: found {len(files)} fleet files, {files[0]} and {files[1]}; give one, with all in it")
    described = read_fleet_file(files[0]) if files else Members(members=())
    # Paths are resolved, so that a campaign given in two spellings counts once.
    known = {member.source.resolve() for member in described.members}
    plain = [p for p in dict.fromkeys(paths) if _fleet_file(p) is None and _folder_or_file(p).resolve() not in known]
    for path in plain:
        _refuse_no_campaign(path, "")
    others = (Member(source=_folder_or_file(p), label=n, unit=n) for p, n in zip(plain, _labels(plain), strict=True))
    members = (*described.members, *others)
    if not members:
        raise UsageError("fleet: nothing is given; give campaign folders, or a fleet file that names them")
    _refuse_same_folder(members)
    return Members(
        members=members,
        before_after=described.before_after,
        false_discovery_rate=described.false_discovery_rate,
    )


def read_fleet_file(path: Path | str) -> Members:
    """Return the campaigns that a fleet file names; folders are relative to the file.

    Raises
    ------
    InputFileError
        The file is missing or wrong; the message is one line with place, value found and remedy.
    """
    path = Path(path)
    table, place = read_toml(path, "fleet"), Place(path.name)
    refuse_unknown_keys(table, KEYS, place)
    entries = tables(table, "campaign", place)
    if not entries:
        raise place.key("campaign").error('missing; write [[campaign]] with folder = "..." for each campaign')
    rate = number(table.get("false_discovery_rate", RATE), place.key("false_discovery_rate"), "1")
    if not 0.0 < rate < 1.0:
        raise place.key("false_discovery_rate").error(f"found {rate:.9g}; write a share between 0 and 1, as 0.05")
    names = _labels([path.parent / _folder(entry, at) for entry, at in entries])
    members = tuple(_member(entry, at, path.parent, n) for (entry, at), n in zip(entries, names, strict=True))
    _refuse_twice(members, [at for _, at in entries])
    _refuse_contradictions(members, [at for _, at in entries])
    return Members(members=members, before_after=_state_pairs(table, place, members), false_discovery_rate=rate)


def _fleet_file(path: Path) -> Path | None:
    """Return the fleet file that a path is or contains; None for a campaign."""
    if is_folder(path):
        return path / FILE_NAME if (path / FILE_NAME).is_file() else None
    if path.suffix != ".toml" or path.name == CAMPAIGN_NAME:
        return None
    # A fleet file may have any name; its [[campaign]] tables identify it.
    return path if path.name == FILE_NAME or isinstance(read_toml(path).get("campaign"), list) else None


def _folder_or_file(path: Path) -> Path:
    """Return the folder of a campaign or a fit whose file has the usual name, else the path itself."""
    return path.parent if path.name in (CAMPAIGN_NAME, ESTIMATE_NAME) else path


def _labels(paths: Sequence[Path]) -> list[str]:
    """Return distinguishing names: of the folder, or of a file with an unusual name."""
    return short_names([whole.with_suffix("") if is_file(whole := _folder_or_file(path)) else whole for path in paths])


def _folder(entry: Mapping[str, Any], place: Place) -> str:
    return text(required_entry(entry, "folder", place, FOLDER_REMEDY), place.key("folder"), FOLDER_REMEDY)


def _member(entry: Mapping[str, Any], place: Place, base: Path, name: str) -> Member:
    refuse_unknown_keys(entry, CAMPAIGN_KEYS, place)
    source = base / _folder(entry, place)
    _refuse_no_campaign(source, f"{place.key('folder')}: ")
    words = {
        key: text(entry[key], place.key(key), f'write {key} = "..."') for key in CAMPAIGN_KEYS[1:5] if key in entry
    }
    label = words.pop("label", name)
    return Member(
        source=_folder_or_file(source),
        label=label,
        unit=words.pop("unit", label),
        covariates=_covariates(entry.get("covariates", {}), place.key("covariates")),
        **words,
    )


def _covariates(entry: Any, place: Place) -> dict[str, Covariate]:
    """Return numbers and dates by name."""
    if not is_table(entry):
        raise place.error(
            f"{describe_entry(entry)}; write a table, as {{ temperature_degC = 20.0, date = 2026-03-01 }}"
        )
    return {
        key: value if isinstance(value, date) else number(value, place.key(key), "1") for key, value in entry.items()
    }


def _state_pairs(table: Mapping[str, Any], place: Place, members: Sequence[Member]) -> tuple[tuple[str, str], ...]:
    """Return the pairs of states; each state must occur, and at most once per unit."""
    entry, here = table.get("before_after", []), place.key("before_after")
    if not isinstance(entry, list):
        raise here.error(f"{describe_entry(entry)}; {PAIR_REMEDY}")
    states = dict.fromkeys(m.state for m in members if m.state)
    pairs = []
    for k, one in enumerate(entry):
        pair = texts(one, here.item(k), PAIR_REMEDY)
        if len(pair) != 2:
            raise here.item(k).error(f"found {len(pair)} states; {PAIR_REMEDY}")
        for state in pair:
            if state not in states:
                known = quote_words(states) or 'none has one: write state = "..." in each [[campaign]]'
                raise here.item(k).error(f'no campaign has state = "{state}"; the states are {known}')
            _refuse_two_of_a_state(members, state, here.item(k))
        pairs.append((pair[0], pair[1]))
    return tuple(pairs)


def _refuse_two_of_a_state(members: Sequence[Member], state: str, place: Place) -> None:
    units = [m.unit for m in members if m.state == state]
    twice = next((unit for k, unit in enumerate(units) if unit in units[:k]), None)
    if twice is not None:
        raise place.error(f'unit "{twice}" has several campaigns with state = "{state}"; {STATE_REMEDY}')


def _refuse_no_campaign(path: Path, where: str) -> None:
    """Refuse a path that holds neither a campaign nor a finished fit."""
    if not is_there(path):
        raise InputFileError(f"{where}{path}: there is no such folder or file; check the path")
    if path.is_dir() and not any((path / name).is_file() for name in (CAMPAIGN_NAME, ESTIMATE_NAME)):
        raise InputFileError(
            f"{where}{path}: holds neither {CAMPAIGN_NAME} nor {ESTIMATE_NAME}; give the folder of a campaign, or the "
            "result folder of mechid identify"
        )


def _refuse_twice(members: Sequence[Member], places: Sequence[Place]) -> None:
    """Refuse a repeated campaign or label."""
    for k, (member, place) in enumerate(zip(members, places, strict=True)):
        before = members[:k]
        if member.source.resolve() in {m.source.resolve() for m in before}:
            raise place.key("folder").error(f"{member.source}: is listed twice; keep one")
        if member.label in {m.label for m in before}:
            raise place.key("label").error(f'"{member.label}" stands here twice; give each campaign its own label')


def _refuse_contradictions(members: Sequence[Member], places: Sequence[Place]) -> None:
    """Refuse a unit in two groups, and a covariate that is a date in one campaign and a number in another."""
    groups: dict[str, str] = {}
    kinds: dict[str, bool] = {}
    for member, place in zip(members, places, strict=True):
        if groups.setdefault(member.unit, member.group) != member.group:
            before = groups[member.unit]
            raise place.key("group").error(
                f'found "{member.group}", and "{before}" in another campaign of unit "{member.unit}"; a group belongs '
                "to a unit and is the same in all its campaigns; use state for changes"
            )
        for name, value in member.covariates.items():
            if kinds.setdefault(name, isinstance(value, date)) != isinstance(value, date):
                raise place.key("covariates").key(name).error("is a date here and a number elsewhere; write one kind")


def _refuse_same_folder(members: Sequence[Member]) -> None:
    """Refuse labels that would share a folder of results."""
    labels: dict[str, str] = {}
    for member in members:
        # Some file systems ignore case.
        other = labels.setdefault(member.folder_name.lower(), member.label)
        if other != member.label or sum(m.label == member.label for m in members) > 1:
            raise InputFileError(
                f'fleet: labels "{other}" and "{member.label}" give the same folder of results; give labels that '
                f"differ in letters or digits in {FILE_NAME}"
            )
