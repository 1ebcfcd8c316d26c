"""Screening of records in which too many mechanisms lose steps or exceed the transducer's range."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.step_loss import DriveResult, drive
from mechid.identification.computation.parallel import map_tasks
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Screening:
    """Outcome of each mechanism in each record; the first mechanism is the assumed one.

    Attributes
    ----------
    lost : (mechanisms, records) of bool
        Whether steps are lost.
    peak : (mechanisms, records)
        Largest torque, N m.
    """

    lost: BoolArray
    peak: FloatArray

    def objections(self, risk: float, range_Nm: float | None) -> list[str]:
        """Return for each record why it cannot be driven, empty if it can."""
        over = self.peak > (range_Nm or np.inf)
        return [self._objection(k, over[:, k], risk) for k in range(self.lost.shape[1])]

    def _objection(self, k: int, over: BoolArray, risk: float) -> str:
        for bad, word in ((self.lost[:, k], "loses steps"), (over, "exceeds the torque range")):
            # The assumed mechanism excludes a record at any admitted risk.
            if bad[0]:
                return f"{word} at the values believed"
            if bad.mean() > risk:
                return f"{word} in {100.0 * bad.mean():.0f} % of the mechanisms"
        return ""


def screen(mechanisms: Sequence[Mechanism], records: Sequence[PlannedRecord], workers: int = 1) -> Screening:
    """Simulate each mechanism through each record."""
    # One task per record; the result is indexed by mechanism first, hence the transposes.
    found = map_tasks(partial(_drive_all, mechanisms), records, workers)
    lost = np.array([[d.lost for d in column] for column in found], dtype=np.bool_)
    peak = np.array([[d.peak_torque for d in column] for column in found])
    return Screening(lost.T, peak.T)


def _drive_all(mechanisms: Sequence[Mechanism], record: PlannedRecord) -> list[DriveResult]:
    return [drive(m, record.command, record.duration_s) for m in mechanisms]
