"""Cache of results at points of a mechanism's coordinates, which all records of a problem request."""

from __future__ import annotations

from collections.abc import Callable

from mechid.arrays import FloatArray
from mechid.identification.output_error.settings import PROBLEM


class PointCache(dict[tuple[str, bytes], FloatArray]):
    """Results by kind and the bytes of a point. They are not part of a problem: a pickled cache is empty."""

    def of(self, kind: str, q: FloatArray, work: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Return the result of `work` at a point, computed once; callers must not write to it."""
        key = kind, q.tobytes()
        found = self.get(key)
        if found is None:
            if len(self) >= PROBLEM.results_kept:
                self.clear()
            found = self[key] = work(q)
        return found

    def __reduce__(self) -> tuple[type[PointCache], tuple[()]]:
        """Pickle without the results, so that equal problems are sent to a worker as equal bytes."""
        return PointCache, ()
