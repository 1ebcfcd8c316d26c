"""Result of a quiet drive: table, codes, emission before and after, reserve, survey, driver registers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mechid.arrays import FloatArray
from mechid.budgets.prediction import Prediction
from mechid.display import DisplayedResult
from mechid.quiet_drives.confirmation import Confirmation
from mechid.quiet_drives.design_file import QuietDesign
from mechid.quiet_drives.improvement import Improvement
from mechid.quiet_drives.rate_survey import Survey
from mechid.quiet_drives.rounding import RoundedTable
from mechid.quiet_drives.step_reserve import Reserve

if TYPE_CHECKING:
    from mechid.quiet_drives.driver_layouts import DriverLayout


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QuietDrive(DisplayedResult):
    """Microstep table and rates with which a mechanism disturbs least.

    Attributes
    ----------
    design : QuietDesign
        With rates, range and microsteps filled in.
    nominal : (4 n, 2)
        Sine table, fractions of the peak.
    exact : (4 n, 2)
        Found table before rounding.
    rounded : RoundedTable
    improvement : Improvement
        Of the rounded table.
    reserves : tuple of Reserve
    kept_share : float
        Share of the found change that the torque reserve allows.
    worst_rise_db : float
        Largest rise of the RMS torque over the range against the nominal table; negative if it falls everywhere.
    worst_rate : float
        Rate of that rise, full steps/s.
    survey : Survey
    predictions : mapping of str to tuple of Prediction
        Verdicts on the requirements with the nominal table and with the found one.
    drivers : tuple of DriverLayout
    confirmations : tuple of Confirmation
        Records that would show the improvement; empty if the records' noise is not known.
    source : str
        The fit.
    grade : str
    synthetic : bool
    digest : str
        SHA-256 of the fitted mechanism's file.
    cpu_s : float
        Processor time of the table search, rounding included.
    """

    design: QuietDesign
    nominal: FloatArray
    exact: FloatArray
    rounded: RoundedTable
    improvement: Improvement
    reserves: tuple[Reserve, ...]
    kept_share: float
    worst_rise_db: float
    worst_rate: float
    survey: Survey
    predictions: Mapping[str, tuple[Prediction, ...]]
    drivers: tuple[DriverLayout, ...]
    confirmations: tuple[Confirmation, ...]
    source: str
    grade: str
    synthetic: bool
    digest: str
    cpu_s: float

    @property
    def table(self) -> FloatArray:
        """Table of the converter's codes, (4 n, 2), fractions of the nominal peak."""
        return self.rounded.values
