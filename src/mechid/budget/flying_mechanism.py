"""From estimate.json to the mechanism that flies: values, covariance and spread; test-stand blocks removed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from mechid.budget.discrepancy import Discrepancy, read_discrepancy
from mechid.budget.flight_entry import Flight
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.mechanism_structure import detent_order
from mechid.errors import InputFileError, did_you_mean
from mechid.identification.result.estimate_file import read_estimate
from mechid.identification.result.fit import FitOutcome
from mechid.parameter import Parameter
from mechid.plant.flight import in_flight
from mechid.plant.mechanism import Mechanism
from mechid.structure import Modes

FloatArray = NDArray[np.float64]

TEST_STAND = ("housing",)
"""Tables of the mechanism that stay on the bench: the paper's housing filter has no reaction on it."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a budget takes of an estimate.

    Attributes
    ----------
    mechanism : Mechanism
        As it flies, on a held base: rigid or flexible load, no housing.
    names : tuple of str, (n,)
        Estimated parameters that fly, then those of `Flight.uncertain`.
    covariance : (n, n)
        Of them, in the mechanism file's units.
    discrepancy : Discrepancy
        What the model misses on validation records.
    removed : tuple of str
        Estimated parameters of the test stand.
    outcome : str
        The fit's own sentence where it did not succeed, else empty.
    """

    mechanism: Mechanism
    names: tuple[str, ...]
    covariance: FloatArray
    discrepancy: Discrepancy
    removed: tuple[str, ...]
    outcome: str = ""


def read_flying(path: Path, flight: Flight) -> Estimate:
    """Return the mechanism of an estimate with what flies in place of the bench's.

    Raises
    ------
    InputFileError
        The estimate is missing or wrong, or the flight names a parameter that the mechanism has not.
    """
    content = read_estimate(path)
    values = {name: entry["value"] for name, entry in content["parameters"].items()}
    own = {n: v for n, v in values.items() if n.partition(".")[0] not in TEST_STAND}
    for where, given in (("values", flight.values), ("spread", flight.spread), ("uncertain", flight.uncertain)):
        for name in given:
            if name not in own:
                near = did_you_mean(name, own) or f"; the parameters are {', '.join(own)}"
                raise InputFileError(f"flight.{where}: unknown parameter {name}{near}")
        for name in given if where != "values" else ():
            if content["parameters"][name]["status"] == "tied" and name not in flight.values:
                raise InputFileError(f"flight.{where}: {name} follows another parameter; name that one")
    names, covariance = _covariance(content, path)
    flying = [k for k, name in enumerate(names) if name in own and name not in flight.values]
    known = tuple(names[k] for k in flying)
    for name in set(flight.uncertain) & set(known):
        raise InputFileError(f"flight.uncertain: {name} is estimated and has its error from there; leave it out")
    return Estimate(
        mechanism=_mechanism({**own, **flight.values}, flight, content["parameters"], path.name),
        names=(*known, *flight.uncertain),
        covariance=block_diag(covariance[np.ix_(flying, flying)], np.diag(np.square(list(flight.uncertain.values())))),
        discrepancy=read_discrepancy(content, path.parent),
        removed=tuple(name for name in names if name not in own),
        outcome=_doubt(content["outcome"]),
    )


def on_base(mechanism: Mechanism, modes: Modes) -> Mechanism:
    """Return the mechanism of a held base on the modes of a structure."""
    shapes = np.column_stack([modes.omega, modes.damping, modes.interface])
    values = {f"base.{k}.{key}": v for k, row in enumerate(shapes) for key, v in zip(_SHAPE, row, strict=True)}
    orders = _orders(mechanism)
    load_modes = sum(name.startswith("load.") and name.endswith(".shape") for name in mechanism.parameters)
    plant = in_flight(orders, len(shapes), load_modes)
    own = {
        name: mechanism.parameters.get(name) or Parameter(name=name, value=float(values[name]), declaration=d)
        for name, d in plant.declarations.items()
    }
    return Mechanism(plant, own, mechanism.options)


_SHAPE = ("frequency", "damping", "shape")


def _mechanism(values: Mapping[str, float], flight: Flight, entries: Mapping[str, Any], label: str) -> Mechanism:
    """Return the mechanism of plain values; a tied parameter stays tied."""
    tied = [name for name, entry in entries.items() if entry["status"] == "tied" and name not in flight.values]
    rigid = mechanism_from_table(_nested({n: v for n, v in values.items() if n not in tied}), label)
    hub = rigid.value("load.inertia") - sum(mode.inertia for mode in flight.load_modes)
    if hub <= 0.0:
        total = rigid.value("load.inertia")
        raise InputFileError(f"flight.load_mode: their inertias leave nothing of the load's {total:.9g} kg m2")
    plant = in_flight(_orders(rigid), 0, len(flight.load_modes))
    modes = {
        f"load.{k}.{key}": value
        for k, mode in enumerate(flight.load_modes)
        for key, value in zip(
            _SHAPE, (2.0 * np.pi * mode.frequency_hz, mode.damping, np.sqrt(mode.inertia)), strict=True
        )
    }
    parameters = {
        name: rigid.parameters.get(name) or Parameter(name=name, value=modes[name], declaration=d)
        for name, d in plant.declarations.items()
    }
    return Mechanism(plant, parameters, {})


def _orders(mechanism: Mechanism) -> list[int | None]:
    periods = [name for name in mechanism.parameters if name.endswith(".period_deg")]
    poles = mechanism.value("stepper.poles")
    return [detent_order(poles, mechanism.value(name)) for name in periods]


def _nested(values: Mapping[str, float]) -> dict[str, Any]:
    """Return dotted names as the tables of a mechanism file; detents are a list."""
    table: dict[str, Any] = {}
    for name, value in values.items():
        *path, key = name.split(".")
        place: Any = table
        for part in path:
            if part.isdigit():
                continue
            if part == "detent":
                detents = place.setdefault("detent", [])
                while len(detents) <= int(path[-1]):
                    detents.append({})
                place = detents[int(path[-1])]
            else:
                place = place.setdefault(part, {})
        place[key] = value
    return table


def _doubt(outcome: Mapping[str, Any]) -> str:
    good = {o.code for o in FitOutcome if o.good}
    return "" if outcome["code"] in good else str(outcome["message"])


def _covariance(content: Mapping[str, Any], path: Path) -> tuple[tuple[str, ...], FloatArray]:
    """Return names and covariance from correlation and standard errors."""
    names = tuple(content["correlation"]["names"])
    sigma = np.array([content["parameters"][n]["std_error"] or np.nan for n in names], dtype=np.float64)
    matrix = np.array(content["correlation"]["matrix"], dtype=np.float64).reshape(len(names), len(names))
    covariance = matrix * np.outer(sigma, sigma)
    if not np.isfinite(covariance).all():
        raise InputFileError(f"{path.name}: correlation or a standard error is missing; identify to the end")
    return names, covariance
