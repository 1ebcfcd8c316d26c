"""Campaigns of a fleet with their units, groups, states and covariates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import TypeAlias

from mechid.fleets.significance import RATE

Covariate: TypeAlias = float | date


@dataclass(frozen=True, kw_only=True)
class Member:
    """Campaign of a fleet.

    Attributes
    ----------
    source : Path
        Campaign file, its folder, or the result folder of an identification.
    label : str
        Name in tables and figures.
    unit : str
        Piece of hardware; several campaigns may belong to one.
    group : str
        Group of the unit, such as its lot; empty if not given.
    state : str
        State of the unit at the campaign, such as "before vibration"; empty if not given.
    covariates : mapping of str to float or date
    """

    source: Path
    label: str
    unit: str
    group: str = ""
    state: str = ""
    covariates: Mapping[str, Covariate] = field(default_factory=dict)

    @property
    def folder_name(self) -> str:
        """Name of its result folder: the label, with characters that file names may not contain replaced."""
        # A leading full stop would hide the folder, and Windows drops a trailing one.
        return re.sub(r"[^A-Za-z0-9._-]+", "_", self.label).strip("._") or "_"


@dataclass(frozen=True, kw_only=True)
class Members:
    """Campaigns of a fleet, and the requested comparisons.

    Attributes
    ----------
    members : tuple of Member
    before_after : tuple of (str, str)
        States of one unit to compare.
    false_discovery_rate : float
        Expected share of false findings.
    """

    members: tuple[Member, ...]
    before_after: tuple[tuple[str, str], ...] = ()
    false_discovery_rate: float = RATE

    @property
    def units(self) -> tuple[str, ...]:
        """Names of the units, in order of appearance."""
        return tuple(dict.fromkeys(m.unit for m in self.members))

    @property
    def covariates(self) -> tuple[str, ...]:
        """Names of the covariates of all campaigns, in order of appearance."""
        return tuple(dict.fromkeys(name for m in self.members for name in m.covariates))

    @property
    def baseline(self) -> tuple[Member, ...]:
        """Campaigns used for comparing units: those that are not in a later state of a pair."""
        after = {later for _, later in self.before_after}
        return tuple(m for m in self.members if m.state not in after)
