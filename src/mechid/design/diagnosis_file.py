"""The folder that a diagnosis leaves: the effects that it names, and those that its records cannot tell from them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.campaign.mechanism_file import read_mechanism
from mechid.errors import InputFileError
from mechid.plant.mechanism import Mechanism

FORMAT = "mechid-diagnosis/1"
DATA_NAME, PROPOSED_NAME = "diagnose.json", "mechanism_proposed.toml"


@dataclass(frozen=True)
class NamedEffect:
    """An effect that a diagnosis names.

    Attributes
    ----------
    name : str
    words : str
    values : mapping of str to float
        Of its parameters by dotted name, as in the proposed mechanism file.
    aliases : tuple of str
        Effects that explain the records as well in its place.
    """

    name: str
    words: str
    values: Mapping[str, float]
    aliases: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class DiagnosisFile:
    """What a diagnosis has found.

    Attributes
    ----------
    path : Path
        Of diagnose.json.
    effects : tuple of NamedEffect
    over_noise : float
        RMS over that of the noise of what the mechanism with these effects leaves.
    mechanism : Mechanism or None
        With these effects, at their values; None where there are none.
    """

    path: Path
    effects: tuple[NamedEffect, ...]
    over_noise: float
    mechanism: Mechanism | None

    @property
    def groups(self) -> tuple[NamedEffect, ...]:
        """The effects that have rivals."""
        return tuple(effect for effect in self.effects if effect.aliases)


def read_diagnosis(folder: Path | str) -> DiagnosisFile:
    """Return what a folder of ``mechid diagnose`` holds.

    Raises
    ------
    InputFileError
        A file is missing, damaged, or not of the format; one line.
    """
    path = Path(folder) / DATA_NAME
    content = _content(path)
    try:
        effects = tuple(_effect(entry) for entry in content["missing"])
        over_noise = float(content["over_noise"]["with_effects"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        wrong = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise InputFileError(f"{path}: is damaged ({wrong}); run mechid diagnose anew") from error
    mechanism = read_mechanism(path.parent / PROPOSED_NAME) if effects else None
    return DiagnosisFile(path, effects, over_noise, mechanism)


def _content(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        why = f"cannot be read ({error.strerror})"
        raise InputFileError(f"{path}: {why}; give the folder that mechid diagnose has left") from error
    except ValueError as error:
        raise InputFileError(f"{path}: is damaged ({error}); run mechid diagnose anew") from error
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise InputFileError(f'{path}: format: found {json.dumps(found)}; this mechid reads "{FORMAT}"')
    return dict(content)


def _effect(entry: Mapping[str, Any]) -> NamedEffect:
    values = {name: float(p["value"]) for name, p in entry["parameters"].items()}
    return NamedEffect(str(entry["name"]), str(entry["words"]), values, tuple(map(str, entry["aliases"])))
