"""Set of records with predicted errors at the assumed values and over the possible mechanisms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.designs.criterion import Criterion
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.prediction import PredictedErrors, planned_problem, predicted_errors
from mechid.designs.prior_knowledge import PriorKnowledge


@dataclass(frozen=True, eq=False)
class RecordSet:
    """Records, their predicted errors, and their test time.

    Attributes
    ----------
    records : tuple of PlannedRecord
    errors : PredictedErrors
        At the assumed values, together with the information of a fit.
    spread : mapping of str to (float, float)
        Median and 90 % quantile of each standard error over the possible mechanisms.
    criterion : float
        Logarithm of a standard error.
    seconds : float
        Test time, including the time between records.
    """

    records: tuple[PlannedRecord, ...]
    errors: PredictedErrors
    spread: dict[str, tuple[float, float]]
    criterion: float
    seconds: float


def record_set(
    here: PriorKnowledge,
    records: Sequence[PlannedRecord],
    information: FloatArray,
    criterion: Criterion,
    *,
    between_s: float,
    workers: int = 1,
) -> RecordSet:
    """Return the predicted errors of records taken together.

    Parameters
    ----------
    here : PriorKnowledge
    records : sequence of PlannedRecord
    information : (points, records, n, n)
        Of each record at each possible mechanism of the prior knowledge.
    criterion : Criterion
    between_s : float
        Additional test time per record, s.
    workers : int
        Number of threads.

    Raises
    ------
    ArithmeticError
        A record cannot be simulated at the assumed values.
    """
    total = here.before + information.sum(axis=1)
    return RecordSet(
        records=tuple(records),
        errors=_errors(here, records, workers),
        spread=_spread(here, total),
        criterion=float(criterion.of(total)),
        seconds=sum(r.duration_s + between_s for r in records),
    )


def _errors(here: PriorKnowledge, records: Sequence[PlannedRecord], workers: int) -> PredictedErrors:
    problem = planned_problem(here.space, records, priors=here.priors, workers=workers)
    own = problem.start[here.space.size :]
    return predicted_errors(problem, np.concatenate([here.points[0], own]), here.known)


def errors_by_record(here: PriorKnowledge, information: FloatArray) -> dict[str, tuple[float, ...]]:
    """Return the median standard error of each parameter before the first record and after each one.

    Parameters
    ----------
    here : PriorKnowledge
    information : (points, records, n, n)
        Of each record at each possible mechanism of the prior knowledge, in the order of the test.
    """
    before = np.broadcast_to(here.before, (len(here.points), 1, *here.before.shape))
    names, errors = _standard_errors(here, np.cumsum(np.concatenate([before, information], axis=1), axis=1))
    return dict(zip(names, map(tuple, np.median(errors, axis=0).T.tolist()), strict=True))


def _spread(here: PriorKnowledge, total: FloatArray) -> dict[str, tuple[float, float]]:
    """Return median and 90 % quantile of each parameter's standard error over the mechanisms."""
    names, errors = _standard_errors(here, total[:, None])
    middle, high = np.quantile(errors[:, 0], (0.5, 0.9), axis=0)
    return {name: (float(a), float(b)) for name, a, b in zip(names, middle, high, strict=True)}


def _standard_errors(here: PriorKnowledge, information: FloatArray) -> tuple[Sequence[str], FloatArray]:
    """Return the parameters and their standard errors, (points, k, parameters), of informations (points, k, n, n)."""
    rows = []
    for q, of_point in zip(here.points, information, strict=True):
        names, slopes = here.space.value_jacobian(q)
        inverses = np.linalg.inv(of_point)
        # Rounding may leave a variance near 0 negative.
        rows.append([np.sqrt(np.einsum("ij,jk,ik->i", slopes, one, slopes).clip(min=0.0)) for one in inverses])
    return names, np.array(rows)
