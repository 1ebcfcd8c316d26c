"""Whether parts of the records contradict one another over the parameters: what model error leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from mechid.identification.result.settings import GRADE


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """How much the parts of one kind scatter, beside what noise alone explains.

    Attributes
    ----------
    ratio : float
        Of the scatter of the parts' scores to that which the noise explains, 1 where there is no model error.
    z : float
        By how many standard deviations of chance its square is above what is expected.
    clusters : int
        Parts compared.
    by_ratio : float or None
        The ratio from which parts contradict each other where noise has no model to count chance by; None where it has.
    """

    ratio: float
    z: float
    clusters: int
    by_ratio: float | None = None

    @property
    def agrees(self) -> bool:
        """Whether noise alone explains it."""
        return self.z <= GRADE.by_chance if self.by_ratio is None else self.ratio < self.by_ratio


@dataclass(frozen=True, kw_only=True)
class Consistency:
    """Scatter between the phases of a step, between records and over time, each None where it was not tested.

    `parameter` and `contested_record` are what is contested most; None where all agrees.
    """

    phase: Scatter | None = None
    record: Scatter | None = None
    time: Scatter | None = None
    parameter: str | None = None
    contested_record: str | None = None

    @property
    def agrees(self) -> bool:
        """Whether the parts of the records agree: noise alone explains how they scatter.

        Stretches of time count where there are neither phases nor several records: a hum, which stays in phase over a
        stretch, scatters them without moving any value.
        """
        tests = [test for test in (self.phase, self.record) if test is not None]
        if tests:
            return all(test.agrees for test in tests)
        return self.time is None or self.time.agrees

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of estimate.json."""
        return asdict(self)

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what an entry of estimate.json says."""
        tests = {key: Scatter(**entry[key]) if entry[key] else None for key in ("phase", "record", "time")}
        return cls(parameter=entry["parameter"], contested_record=entry["contested_record"], **tests)
