"""Result of an identification: values with their uncertainty, records, stages, outcome, warnings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.display import DisplayedResult
from mechid.errors import UsageError, did_you_mean
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.grade import Consistency, FitOutcome, Grade, Reason
from mechid.identification.result.missing_effects import AsWritten, Missing, SuggestedEffect
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.record_result import RecordFit
from mechid.parameter import Status
from mechid.plant.mechanism import Mechanism

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

ESTIMATE_NAME, FORMAT = "estimate.json", "mechid-estimate/1"
ESTIMATED_STATUSES = (Status.FREE, Status.AT_BOUND)
"""Statuses of the parameters that a fit estimates."""
OPTIMUM = "_optimum"
"""Attribute under which a fit keeps its optimum."""
LINEAR = "mechid.exports.linear.linear"
"""Module of the linear models of a fit. It lies in a higher layer, so it is imported by name on first use."""
REBUILD = "mechid.identification.refit.rebuild"
"""Module that rebuilds the optimum of a fit; imported likewise."""
PLOT = "mechid.analysis.fit_plot"
"""Module that draws a fit; imported likewise."""
MECHANISM_FILE = "mechid.identification.result.estimate_file"
"""Module that reads the mechanism file beside an estimate; imported likewise."""


@dataclass(frozen=True, kw_only=True)
class StageReport:
    """One stage of the search: seconds used of each record, free parameters, cost, evaluations and time."""

    name: str
    records: Mapping[str, float]
    free: tuple[str, ...]
    cost: float
    evaluations: int
    seconds: float
    note: str = ""


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum of a fit.

    Attributes
    ----------
    problem : Problem
        Its free parameters are those that the fit estimated; the records have the weights of the last fit.
    q : (n,)
    windows : mapping of str to (int, int)
    triangle : Triangle
        Linearization at `q`.
    parameters : mapping of str to ParameterEstimate
        Estimates of the fit.
    """

    problem: Problem
    q: FloatArray
    windows: Windows
    triangle: Triangle
    parameters: Mapping[str, ParameterEstimate]

    @property
    def estimated_names(self) -> tuple[str, ...]:
        """Names of the parameters that the fit estimated."""
        return tuple(name for name, p in self.parameters.items() if p.status in ESTIMATED_STATUSES)

    def estimate_of(self, name: str) -> ParameterEstimate:
        """Return the estimate of a parameter; UsageError if the fit did not estimate it."""
        if name not in self.estimated_names:
            known = self.parameters.get(name)
            state = f"is {known.status}" if known else f"is not in the fit{did_you_mean(name, self.estimated_names)}"
            raise UsageError(f"--parameter {name}: {state}; the fit estimated {', '.join(self.estimated_names)}")
        return self.parameters[name]

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the estimated parameters at a point, in the file's units."""
        return self.problem.coordinates.values(q)


@dataclass(frozen=True, kw_only=True, repr=False)
class Fit(DisplayedResult):
    """The result of an identification; `estimate.json` holds the same values.

    Attributes
    ----------
    mechanism : Mechanism
        The graded mechanism, with the estimated values and the added terms.
    parameters : mapping of dotted name to ParameterEstimate
    correlation_names : tuple of str, (n,)
        The free parameters.
    correlation, covariance : (n, n)
        In the file's coordinates and units; the covariance is robust to coloured noise.
    records : mapping of name to RecordFit
    stages : tuple of StageReport
    outcome : FitOutcome
    path : tuple of str
        Names of the strategies that the search tried, in order; the last one reached the records' ends. Empty
        where the file has stages, or the values were given.
    warnings : tuple of str
        Possible causes of a wrong result, each with its remedy.
    notes : tuple of str
        Ambiguities that records of this kind cannot resolve.
    provenance : mapping
        Versions, digests of the inputs, seed, wall time.
    consistency : Consistency or None
        Agreement between parts of the records; None where it was not tested.
    grade : Grade
        Usability of the values and their errors.
    reasons : tuple of Reason
        Reasons why the grade is not better.
    synthetic : bool
        Whether the records were simulated.
    missing : tuple of Missing
        Effects that the files do not declare and the records need, added to the fit: terms and laws of the mechanism,
        and disturbances of the records.
    suggested : tuple of SuggestedEffect
        Candidate effects for the residual of a fit of grade B or C without added terms, the likeliest first.
    as_written : AsWritten or None
        Prediction by the mechanism as written at these values; None where nothing was added to it.
    completed : tuple of mapping, or None
        Steps by which the mechanism was completed (docs/files.md); None where it is as the campaign file names it.
    mains_hz : float or None
        Frequency of the grid, Hz, whose hum was removed or is left in the records; None where none is evident.
    campaign : Campaign or None
        The identified campaign, where it is available: in fits from `mechid.identify` and `mechid.load_fit`.
    folder : Path or None
        Result folder from which the fit was read; None for a fit that was not read from a file.
    """

    mechanism: Mechanism
    parameters: Mapping[str, ParameterEstimate]
    correlation_names: tuple[str, ...]
    correlation: FloatArray
    covariance: FloatArray
    records: Mapping[str, RecordFit]
    stages: tuple[StageReport, ...]
    outcome: FitOutcome
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    provenance: Mapping[str, object]
    consistency: Consistency | None = None
    mains_hz: float | None = None
    grade: Grade = Grade.FAILED
    reasons: tuple[Reason, ...] = ()
    missing: tuple[Missing, ...] = ()
    suggested: tuple[SuggestedEffect, ...] = ()
    as_written: AsWritten | None = None
    completed: tuple[Mapping[str, Any], ...] | None = None
    synthetic: bool = False
    path: tuple[str, ...] = ()
    campaign: Campaign | None = field(default=None, compare=False)
    folder: Path | None = field(default=None, compare=False)

    # Hidden from type checkers: with a visible __getattr__ they would accept any misspelt attribute of a fit.
    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Read the mechanism file of a fit whose numbers alone were read (`read_numbers`)."""
            if name != "mechanism" or not vars(self).get("folder"):
                # Where a property raised AttributeError, Python discards that and calls this: raise it again.
                return object.__getattribute__(self, name)
            read = import_module(MECHANISM_FILE).read_estimated_mechanism
            object.__setattr__(self, name, read(self.provenance, Path(self.source)))
            return self.mechanism

    @property
    def source(self) -> str:
        """Path of the estimate.json, or "the fit" for one in memory; messages name this place."""
        return str(self.folder / ESTIMATE_NAME) if self.folder else "the fit"

    @property
    def mechanism_digest(self) -> str:
        """SHA-256 of the mechanism file that was left beside its estimate.json; empty for a fit not written yet."""
        return str(self.provenance.get("mechanism_sha256") or "")

    @property
    def required_campaign(self) -> Campaign:
        """The campaign of the fit; UsageError where the fit does not hold it."""
        if self.campaign is None:
            raise UsageError("the fit does not hold its campaign; give campaign=, with its records read")
        return self.campaign

    @property
    def added_terms(self) -> tuple[Missing, ...]:
        """Entries of `missing` that are terms or laws of the mechanism, without the disturbances of the records."""
        return tuple(one for one in self.missing if one.block)

    @property
    def start_mechanism(self) -> Mechanism:
        """The mechanism with the start values of the fit."""
        names = {p.name for p in self.mechanism.free}
        return self.mechanism.with_values({n: p.start for n, p in self.parameters.items() if n in names})

    @property
    def values(self) -> dict[str, float]:
        """The value of each parameter by its dotted name, in the file's unit."""
        return {name: p.value for name, p in self.parameters.items()}

    @property
    def inputs_sha256(self) -> Mapping[str, str]:
        """Digests of the input files by file name; empty where the provenance has none."""
        found = self.provenance.get("inputs_sha256")
        return found if isinstance(found, Mapping) else {}

    @property
    def optimum(self) -> Optimum:
        """The problem that the fit solved, at its optimum, with one thread per core.

        Raises
        ------
        UsageError
            If the fit does not hold its campaign.
        InputFileError
            If the files of the campaign are not those of the fit.
        FitError
            If the fit has no optimum.
        """
        return self.optimum_on(os.cpu_count() or 1)

    def optimum_on(self, workers: int) -> Optimum:
        """Return `optimum` with a number of threads. It is rebuilt from the campaign once and cached on this fit."""
        if OPTIMUM not in vars(self):
            # Not a field: copies with other values must not inherit it, and it is neither compared nor pickled.
            vars(self)[OPTIMUM] = import_module(REBUILD).rebuild_optimum(self, workers)
        kept: Optimum = vars(self)[OPTIMUM]
        # The number of threads is set on each call: it is no part of the cached optimum.
        return replace(kept, problem=replace(kept.problem, workers=workers))

    def __getstate__(self) -> dict[str, Any]:
        """Return the attributes to pickle: all but the optimum, which is rebuilt on demand."""
        return {name: value for name, value in vars(self).items() if name != OPTIMUM}

    def linear(
        self,
        campaign: Campaign | None = None,
        *,
        start_angle_deg: float | None = None,
        rates: Sequence[float] | None = None,
        samples: int = 20,
        seed: int = 0,
        values: Mapping[str, float] | None = None,
        stand: bool = False,
        anyway: bool = False,
        **further: Any,
    ) -> Any:
        """Return uncertain linear models at holding, and the torque at steady rates; see `mechid.exports.linear`.

        With the identified campaign, the models hold the first record's start angle and use the records' stepping
        rates; without it, 0 deg and no rates. The keywords are those of `Options` there; `anyway` accepts a failed fit.
        A further one is ``loop="quiet.toml"``, the file of the loops to be closed.
        """
        return import_module(LINEAR).linear_of_fit(
            self,
            campaign,
            anyway,
            start_angle_deg=start_angle_deg,
            rates=None if rates is None else tuple(rates),
            samples=samples,
            seed=seed,
            values=dict(values or {}),
            stand=stand,
            **further,
        )

    def plot(self, record: str | None = None, quantity: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot measurement, model and residual of a record, in SI units over time in s.

        Parameters
        ----------
        record, quantity : str or None
            Defaults: the campaign's first record and its leading channel.
        ax : matplotlib.axes.Axes or None
            None creates new axes.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        UsageError
            If there is no such record or quantity, or the fit does not hold its campaign.
        """
        axes: Axes = import_module(PLOT).plot_fit(self, record, quantity, ax)
        return axes

    def to_pandas(self) -> pd.DataFrame:
        """Return the parameters by dotted name: value, errors, interval, bounds, status (extra ``dataframes``)."""
        # An optional dependency: imported on use.
        import pandas as pd

        return pd.DataFrame({name: p.to_dict() for name, p in self.parameters.items()}).T

    def to_dict(self) -> dict[str, Any]:
        """Return the content of estimate.json."""
        return {
            "format": FORMAT,
            "grade": str(self.grade),
            "synthetic": self.synthetic,
            "grade_reasons": [reason.to_dict() for reason in self.reasons],
            "outcome": {"code": self.outcome.code, "message": self.outcome.value, "path": list(self.path)},
            "parameters": {name: p.to_dict() for name, p in self.parameters.items()},
            "correlation": {"names": list(self.correlation_names), "matrix": self.correlation.tolist()},
            "covariance": {"names": list(self.correlation_names), "matrix": self.covariance.tolist()},
            "consistency": self.consistency.to_dict() if self.consistency else None,
            "mains_hz": self.mains_hz,
            "missing": [one.to_dict() for one in self.missing],
            "suggested": [asdict(one) for one in self.suggested],
            "as_written": self.as_written.to_dict() if self.as_written else None,
            "completed": None if self.completed is None else [dict(step) for step in self.completed],
            "records": {name: r.to_dict() for name, r in self.records.items()},
            "stages": [{**asdict(s), "records": dict(s.records), "free": list(s.free)} for s in self.stages],
            "warnings": list(self.warnings),
            "notes": list(self.notes),
            "provenance": dict(self.provenance),
        }
