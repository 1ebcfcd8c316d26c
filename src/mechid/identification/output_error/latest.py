"""What was worked out last at points of a mechanism's coordinates: all records of a problem ask for the same."""

from __future__ import annotations

from collections.abc import Callable

from mechid.arrays import FloatArray
from mechid.identification.output_error.settings import PROBLEM


class Latest(dict[tuple[str, bytes], FloatArray]):
    """Results by their kind and the bytes of a point. They are no part of a problem: pickled it is empty."""

    def of(self, kind: str, q: FloatArray, work: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Return what `work` gives at a point, worked out once; nobody writes to it."""
        key = kind, q.tobytes()
        found = self.get(key)
        if found is None:
            if len(self) >= PROBLEM.results_kept:
                self.clear()
            found = self[key] = work(q)
        return found

    def __reduce__(self) -> tuple[type[Latest], tuple[()]]:
        """Leave the results behind: what is sent to a worker is the same whatever has been asked for."""
        return Latest, ()
