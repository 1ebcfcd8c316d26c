"""The campaigns of a fleet: where each lies, of which unit it is, and what is known of the unit and of the day."""

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
    """One campaign of a fleet.

    Attributes
    ----------
    source : Path
        Campaign file, its folder, or the result folder of an identification.
    label : str
        By which it is shown.
    unit : str
        The piece of hardware; several campaigns may be of one.
    group : str
        Of the unit, such as its lot; empty where none is given.
    state : str
        Of the unit at the campaign, such as "before vibration"; empty where none is given.
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
        """Name of the folder of its results: the label, with what may not stand in a file name replaced."""
        return re.sub(r"[^A-Za-z0-9._-]+", "_", self.label).strip("._") or "_"


@dataclass(frozen=True, kw_only=True)
class Members:
    """The campaigns of a fleet, and what is asked of them.

    Attributes
    ----------
    members : tuple of Member
    before_after : tuple of (str, str)
        States of one unit to be compared.
    false_discovery_rate : float
        Expected share of the findings that are chance.
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
        """Names of the covariates that any campaign has, in order of appearance."""
        return tuple(dict.fromkeys(name for m in self.members for name in m.covariates))

    @property
    def compared(self) -> tuple[Member, ...]:
        """The campaigns by which units are compared: those in no state that comes after another."""
        after = {later for _, later in self.before_after}
        return tuple(m for m in self.members if m.state not in after)
