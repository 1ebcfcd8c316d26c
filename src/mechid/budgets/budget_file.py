"""Reader of BUDGET.toml: estimate, flight values, modes of operation, structure and requirements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mechid.arrays import FloatArray
from mechid.budgets.error_entry import read_errors
from mechid.budgets.flight_entry import Flight, read_flight
from mechid.budgets.mode_entry import read_modes
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.other_errors import OtherError
from mechid.budgets.requirement import Requirement
from mechid.budgets.requirement_entry import read_requirements
from mechid.budgets.structure_entry import read_frame, read_structure_entry
from mechid.campaign.campaign_in_code import plain
from mechid.campaign.place import Place, describe_entry, refuse_unknown_keys, required_entry, text
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_whole
from mechid.identification.result.fit import ESTIMATE_NAME
from mechid.reading.whole import is_file
from mechid.records.formats import digest_of
from mechid.specification.requirement import Requirement as EmissionRequirement
from mechid.specification.requirement_entry import read_requirements_beside
from mechid.structure import Structure

KEYS = ("estimate", "axis", "seed", "flight", "structure", "mode", "error", "requirement")


@dataclass(frozen=True, kw_only=True)
class BudgetFile:
    """Content of a budget file, its structure loaded.

    `requirements` are on the line of sight, `emission` those on the torque at the interface. `frame` holds the bench's
    axes as columns in the structure's frame, (3, 3); `inputs` the SHA-256 of the files that were read, by name.
    """

    path: Path
    estimate: Path
    flight: Flight
    structure: Structure
    frame: FloatArray
    coupled_below_hz: float
    modes: tuple[OperatingMode, ...]
    requirements: tuple[Requirement, ...]
    errors: tuple[OtherError, ...] = ()
    emission: tuple[EmissionRequirement, ...] = ()
    seed: int = 0
    inputs: Mapping[str, str] = field(default_factory=dict)


def read_budget_file(path: Path | str, *, structure: Structure | None = None, has_estimate: bool = False) -> BudgetFile:
    """Read a budget file.

    Parameters
    ----------
    path : Path
    structure : Structure or None
        Replaces the file named by the table ``structure``.
    has_estimate : bool
        Whether the caller supplies the estimate; the file then need not name one.

    Raises
    ------
    InputFileError
        The file or its structure is missing or wrong; the message is one line with place, value found and remedy.
    """
    path = Path(path)
    return _budget_from_table(read_toml(path, "budget"), path, structure, has_estimate=has_estimate)


def budget_of_table(
    table: Mapping[str, Any], *, structure: Structure | None = None, has_estimate: bool = False
) -> BudgetFile:
    """Return the budget file that tables describe; relative file names refer to the working folder.

    Parameters and errors are those of `read_budget_file`.
    """
    return _budget_from_table(plain(table), Path("budget"), structure, has_estimate=has_estimate)


def _budget_from_table(
    table: Mapping[str, Any], path: Path, given: Structure | None, *, has_estimate: bool
) -> BudgetFile:
    place = Place(path.name)
    refuse_unknown_keys(table, KEYS, place)
    structure, coupled_below_hz = read_structure_entry(table, place, path.parent, given)
    seed = table.get("seed", 0)
    if not is_whole(seed, 0, 2**32):
        raise place.key("seed").error(f"{describe_entry(seed)}; write a whole number from 0")
    return BudgetFile(
        path=path,
        estimate=Path(ESTIMATE_NAME) if has_estimate else path.parent / _estimate(table, place),
        flight=read_flight(table.get("flight", {}), place.key("flight")),
        structure=structure,
        frame=read_frame(table, place),
        coupled_below_hz=coupled_below_hz,
        modes=read_modes(table, place, path.parent),
        requirements=read_requirements(table, place, structure.line_of_sight),
        emission=read_requirements_beside(table, place, path.parent),
        errors=read_errors(table, place, structure.line_of_sight),
        seed=seed,
        inputs=_digests(path, {} if given is not None else table["structure"]),
    )


def _digests(path: Path, structure: Mapping[str, Any]) -> dict[str, str]:
    """Return the SHA-256 of the budget file, if there is one, and of the file of the structure."""
    files = {path.name: path} | ({structure["file"]: path.parent / structure["file"]} if structure else {})
    return {name: digest_of(file) for name, file in files.items() if is_file(file)}


def _estimate(table: Mapping[str, Any], place: Place) -> str:
    remedy = 'write estimate = "estimate.json", the file that mechid identify writes'
    name = required_entry(table, "estimate", place, remedy)
    return text(name, place.key("estimate"), 'write a file name such as "estimate.json"')
