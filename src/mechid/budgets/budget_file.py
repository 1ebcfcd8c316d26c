"""BUDGET.toml: the estimate, what flies, the modes of operation, the structure, the requirements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechid.budgets.error_entry import read_errors
from mechid.budgets.flight_entry import Flight, read_flight
from mechid.budgets.mode_entry import read_modes
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.other_errors import OtherError
from mechid.budgets.requirement import Requirement
from mechid.budgets.requirement_entry import read_requirements
from mechid.budgets.structure_entry import read_frame, read_structure_entry
from mechid.campaign.place import Place, found, refuse_unknown_keys, required, text
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_whole
from mechid.structure import Structure

FloatArray = NDArray[np.float64]

KEYS = ("estimate", "axis", "seed", "flight", "structure", "mode", "error", "requirement")


@dataclass(frozen=True, kw_only=True)
class BudgetFile:
    """What a budget file asks for, its structure read; `frame` has the bench's axes in its frame as columns, (3, 3)."""

    path: Path
    estimate: Path
    flight: Flight
    structure: Structure
    frame: FloatArray
    coupled_below_hz: float
    modes: tuple[OperatingMode, ...]
    requirements: tuple[Requirement, ...]
    errors: tuple[OtherError, ...] = ()
    seed: int = 0


def read_budget_file(path: Path | str) -> BudgetFile:
    """Return what a budget file asks for.

    Raises
    ------
    InputFileError
        The file or its structure is missing or wrong; one line with place, what was found and remedy.
    """
    path = Path(path)
    table, place = read_toml(path, "budget"), Place(path.name)
    refuse_unknown_keys(table, KEYS, place)
    estimate = text(
        required(table, "estimate", place, 'write estimate = "estimate.json", as mechid identify leaves it'),
        place.key("estimate"), 'write the name of a file, as "estimate.json"',
    )  # fmt: skip
    structure, coupled_below_hz = read_structure_entry(table, place, path.parent)
    seed = table.get("seed", 0)
    if not is_whole(seed, 0, 2**32):
        raise place.key("seed").error(f"{found(seed)}; write a whole number from 0")
    return BudgetFile(
        path=path,
        estimate=path.parent / estimate,
        flight=read_flight(table.get("flight", {}), place.key("flight")),
        structure=structure,
        frame=read_frame(table, place),
        coupled_below_hz=coupled_below_hz,
        modes=read_modes(table, place, path.parent),
        requirements=read_requirements(table, place, structure.line_of_sight),
        errors=read_errors(table, place, structure.line_of_sight),
        seed=seed,
    )
