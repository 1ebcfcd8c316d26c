"""From a fit to the mechanism that flies: its mechanism, its covariance, what stays on the bench."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from mechid.analysis.components_file import SideRecords
from mechid.analysis.fit_residuals import FitResiduals, is_simulated
from mechid.arrays import FloatArray
from mechid.budgets.discrepancy import Discrepancy, discrepancy_of
from mechid.budgets.flight_entry import LOAD_INERTIA, Flight
from mechid.budgets.residual_source import ResidualSource, residual_source
from mechid.errors import InputFileError, did_you_mean
from mechid.identification.result.as_fitted import error_covariance, refuse_failed
from mechid.identification.result.estimate_file import DIGEST
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
    """What a budget takes of an estimate.

    Attributes
    ----------
    mechanism : Mechanism
        As it flies, on a held base.
    names : tuple of str, (n,)
        Estimated parameters that fly, then those of `Flight.uncertain`.
    covariance : (n, n)
        Of them, in the mechanism file's units.
    discrepancy : Discrepancy
        What the model misses on validation records.
    left : mapping of str to str
        What stays on the bench, tables and estimated parameters, each with the reason.
    outcome : str
        Why the fit is not to be relied on, empty where it has grade A or B.
    residual : ResidualSource or None
        What the fit left of the bench's torque records; None where identify left none beside the estimate.
    side : SideRecords or None
        Forces and moments that the bench measured beside the torque; None where it did not.
    synthetic : bool
        Whether its records were simulated.
    digest : str
        SHA-256 of the mechanism file that identify left with it; empty of a fit in memory.
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


def flying_estimate(fit: Fit, flight: Flight) -> Estimate:
    """Return the mechanism of a fit with what flies in place of the bench's.

    Raises
    ------
    InputFileError
        The fit has failed or lacks a standard error; what its folder holds of its residuals is wrong; the mechanism
        cannot fly; or the flight names a parameter that it has not.
    UsageError
        The fit has neither a folder nor its campaign.
    """
    refuse_failed(fit, InputFileError)
    bench = fit.mechanism
    modes = [(2.0 * np.pi * m.frequency_hz, m.damping, m.inertia) for m in flight.load_modes] or None
    plant = flying_plant(bench, None if modes is None else len(modes))
    values = dict(_named(flight, plant))
    _check_names(flight, plant, values)
    try:
        flying = to_flight(bench, values, modes)
    except InputFileError as error:
        raise InputFileError(f"{flight.place}: {error}") from error
    _refuse_tied(flight, flying)
    names, covariance = error_covariance(fit)
    if names != fit.correlation_names or not (np.isfinite(covariance).all() and np.diag(covariance).all()):
        raise InputFileError(f"{fit.source}: correlation or a standard error is missing; identify to the end")
    kept = [k for k, name in enumerate(names) if name in flying.parameters and _flies(name) and name not in values]
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
        left=parts_left_on_bench(bench, names),
        outcome=_doubt(fit),
        residual=source,
        side=residuals.components,
        synthetic=is_simulated(fit),
        digest=str(fit.provenance.get(DIGEST, "")),
    )


def on_modes(mechanism: Mechanism, modes: Modes) -> Mechanism:
    """Return the mechanism of a held base on the modes of a structure.

    Raises
    ------
    InputFileError
        A block of the user's own does not say how it moves with its base.
    """
    rows = np.column_stack([modes.omega, modes.damping, modes.interface]).tolist()
    return with_base(mechanism, Flying(base=Base.ON_MODES, modes=len(rows)), rows)


def _flies(name: str) -> bool:
    return not bench_reason(name)


def _named(flight: Flight, plant: Plant) -> Iterator[tuple[str, float]]:
    """Yield the flight's values by dotted names of the plant; a load's inertia is that of what the plant moves."""
    whole = plant.names_with_role(Role.LOAD_INERTIA)
    for name, value in flight.values.items():
        yield (whole[0] if name == LOAD_INERTIA and name not in plant.declarations and whole else name), value


def _check_names(flight: Flight, plant: Plant, values: Iterable[str]) -> None:
    """Refuse names that are none of the flying mechanism's, with the nearest that is."""
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
    """Return why an estimate is not to be relied on; empty for grades A and B."""
    if fit.grade.good:
        return ""
    return " ".join([GRADE_WORDS[fit.grade], *(reason.text for reason in fit.reasons)])
