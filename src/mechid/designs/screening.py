"""Which records cannot be driven: those in which too many of the mechanisms lose steps or exceed the transducer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.designs.planned import PlannedRecord
from mechid.designs.step_loss import Driven, driven
from mechid.identification.computation.parallel import map_tasks
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Screening:
    """How each mechanism comes through each record; the first mechanism is the one believed.

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
        """Return for each record why it cannot be driven, empty where it can."""
        over = self.peak > (range_Nm or np.inf)
        return [self._objection(k, over[:, k], risk) for k in range(self.lost.shape[1])]

    def _objection(self, k: int, over: BoolArray, risk: float) -> str:
        for bad, word in ((self.lost[:, k], "loses steps"), (over, "exceeds the torque range")):
            if bad[0]:
                return f"{word} at the values believed"
            if bad.mean() > risk:
                return f"{word} in {100.0 * bad.mean():.0f} % of the mechanisms"
        return ""


def screening(mechanisms: Sequence[Mechanism], records: Sequence[PlannedRecord], workers: int = 1) -> Screening:
    """Return how each mechanism comes through each record."""
    found = map_tasks(partial(_through, mechanisms), records, workers)
    lost = np.array([[d.lost for d in column] for column in found], dtype=np.bool_)
    peak = np.array([[d.peak_torque for d in column] for column in found])
    return Screening(lost.T, peak.T)


def _through(mechanisms: Sequence[Mechanism], record: PlannedRecord) -> list[Driven]:
    return [driven(m, record.command, record.duration_s) for m in mechanisms]
