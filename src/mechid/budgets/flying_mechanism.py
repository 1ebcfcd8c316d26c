"""Flight configuration of a fit: mechanism, covariance, and the parts that stay on the bench."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from mechid.analysis.components_file import SideRecords
from mechid.analysis.fit_residuals import FitResiduals, is_simulated
from mechid.arrays import FloatArray
from mechid.budgets.discrepancy import Discrepancy, discrepancy_of
from mechid.budgets.flight_entry import LOAD_INERTIA, Flight
from mechid.budgets.origin import origin_of
from mechid.budgets.residual_source import ResidualSource, residual_source
from mechid.errors import InputFileError, did_you_mean
from mechid.identification.result.estimate_file import DIGEST
from mechid.identification.result.finished_fit import error_covariance, refuse_failed
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS
from mechid.parameter import Role
from mechid.plant.flight import FILTER, flying_plant, parts_left_on_bench, to_flight, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant
from mechid.plant.tables import bench_reason
from mechid.structure import Modes


@dataclass(frozen=True, eq=False)
class Estimate:
    """Parts of a fit that a budget uses.

    Attributes
    ----------
    mechanism : Mechanism
        In flight, on a held base.
    names : tuple of str, (n,)
        Estimated parameters that fly, followed by those of `Flight.uncertain`.
    covariance : (n, n)
        Covariance of these parameters, in the mechanism file's units.
    discrepancy : Discrepancy
        Model error on validation records.
    left : mapping of str to str
        Tables and estimated parameters that stay on the bench, each with the reason.
    outcome : str
        Why the fit is not reliable, empty for grades A and B.
    residual : ResidualSource or None
        Residual of the bench's torque records; None if identify left none with the estimate.
    side : SideRecords or None
        Other force and moment components measured on the bench; None without any.
    synthetic : bool
        Whether its records were simulated.
    digest : str
        SHA-256 of the mechanism file that identify wrote with it; empty for a fit in memory.
    origin : mapping
        Test of the fit, as `origin_of` returns it.
    """

    mechanism: Mechanism
    names: tuple[str, ...]
    covariance: FloatArray
    discrepancy: Discrepancy
    left: Mapping[str, str]
    outcome: str = ""
    residual: ResidualSource | None = None
    side: SideRecords | None = None
    synthetic: bool = False
    digest: str = ""
    origin: Mapping[str, Any] = field(default_factory=dict)


def flying_estimate(fit: Fit, flight: Flight, *, stand: bool = False) -> Estimate:
    """Return the mechanism of a fit in its flight configuration.

    Parameters
    ----------
    fit : Fit
    flight : Flight
    stand : bool
        Whether it keeps its test stand, so that its torque is that measured by the transducer.

    Raises
    ------
    InputFileError
        The fit has failed or lacks a standard error; the residual files in its folder are wrong; the mechanism cannot
        fly; or the flight names an unknown parameter.
    UsageError
        The fit has neither a folder nor its campaign.
    """
    refuse_failed(fit, InputFileError)
    bench = fit.mechanism
    modes = [(2.0 * np.pi * m.frequency_hz, m.damping, m.inertia) for m in flight.load_modes] or None
    plant = flying_plant(bench, None if modes is None else len(modes), stand=stand)
    values = dict(_values_by_name(flight, plant))
    _check_names(flight, plant, values)
    try:
        flying = to_flight(bench, values, modes, stand=stand)
    except InputFileError as error:
        raise InputFileError(f"{flight.place}: {error}") from error
    _refuse_tied(flight, flying)
    names, covariance = error_covariance(fit)
    if names != fit.correlation_names or not (np.isfinite(covariance).all() and np.diag(covariance).all()):
        raise InputFileError(f"{fit.source}: correlation or a standard error is missing; identify to the end")
    # A value given for the flight is exact: its error on the bench does not apply.
    kept = [
        k
        for k, name in enumerate(names)
        if name in flying.parameters and (stand or _is_flying(name)) and name not in values
    ]
    known = tuple(names[k] for k in kept)
    for name in set(flight.uncertain) & set(known):
        raise InputFileError(
            f"{flight.place}.uncertain: {name} is estimated and has its error from there; leave it out"
        )
    residuals = FitResiduals(fit)
    source = residual_source(residuals, bench, flying)
    return Estimate(
        mechanism=flying,
        names=(*known, *flight.uncertain),
        covariance=block_diag(covariance[np.ix_(kept, kept)], np.diag(np.square(list(flight.uncertain.values())))),
        discrepancy=discrepancy_of(residuals, of_profiles_alone=source is not None),
        left=parts_left_on_bench(bench, names, stand=stand),
        outcome=_doubt(fit),
        residual=source,
        side=residuals.components,
        synthetic=is_simulated(fit),
        digest=str(fit.provenance.get(DIGEST, "")),
        origin=origin_of(fit),
    )


def on_modes(mechanism: Mechanism, modes: Modes) -> Mechanism:
    """Couple a mechanism on a held base with the modes of a structure.

    Raises
    ------
    InputFileError
        A user-defined block does not specify how it moves with its base.
    """
    rows = np.column_stack([modes.omega, modes.damping, modes.interface]).tolist()
    return with_base(mechanism, Flying(base=Base.ON_MODES, modes=len(rows)), rows)


def _is_flying(name: str) -> bool:
    return not bench_reason(name)


def _values_by_name(flight: Flight, plant: Plant) -> Iterator[tuple[str, float]]:
    """Yield the flight's values by names of the plant; the load's inertia may be that of the whole moved body."""
    whole = plant.names_with_role(Role.LOAD_INERTIA)
    for name, value in flight.values.items():
        yield (whole[0] if name == LOAD_INERTIA and name not in plant.declarations and whole else name), value


def _check_names(flight: Flight, plant: Plant, values: Iterable[str]) -> None:
    """Refuse names that the flying mechanism does not have, and suggest the nearest."""
    own = [name for name in plant.declarations if name not in FILTER]
    for where, given in (("values", values), ("spread", flight.spread), ("uncertain", flight.uncertain)):
        for name in given:
            if reason := bench_reason(name):
                raise InputFileError(f"{flight.place}.{where}: {name} stays on the bench: {reason}; leave it out")
            if name not in own:
                near = did_you_mean(name, own) or f"; the parameters are {', '.join(own)}"
                raise InputFileError(f"{flight.place}.{where}: unknown parameter {name}{near}")


def _refuse_tied(flight: Flight, flying: Mechanism) -> None:
    for where, given in (("spread", flight.spread), ("uncertain", flight.uncertain)):
        for name in given:
            if flying.parameters[name].tied_to:
                raise InputFileError(f"{flight.place}.{where}: {name} follows another parameter; name that one")


def _doubt(fit: Fit) -> str:
    """Return why an estimate is not reliable; empty for grades A and B."""
    if fit.grade.good:
        return ""
    return " ".join([GRADE_WORDS[fit.grade], *(reason.text for reason in fit.reasons)])
