"""What every record has of its own: the mean over the records is the mechanism's."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.target import Target
from mechid.parameter import Parameter


@dataclass(frozen=True)
class Mean:
    """Values of one parameter of the mechanism that every record has of its own: their mean is the mechanism's.

    Without it nothing would tell a supply that is higher in all records from a smaller torque constant, and the
    mechanism's resistance would be unknown where every record has its own.

    Attributes
    ----------
    of : str
        The mechanism's parameter.
    own : tuple of str
        The records' values of it.
    sigma : float
        What the mean is held to it by, in the file's unit: so small that the search never trades it for anything. How
        far the mean may truly be from it is `unknown`.
    """

    of: str
    own: tuple[str, ...]
    sigma: float

    def unknown(self, values: Sequence[float]) -> float:
        """Return the standard deviation of the true mean from the mechanism's value, known by len(own) - 1 degrees.

        s / sqrt(K) with s the scatter of the records' values, (K,): they are draws about the mechanism's.
        """
        return float(np.std(values, ddof=1)) / math.sqrt(len(values))


def means_of(targets: Sequence[Target]) -> Iterator[Mean]:
    """Yield the means of what every record has of its own, free and with a prior."""
    by_name: dict[str, list[Parameter]] = {}
    for p in (p for target in targets for p in target.moved if p.replaces and p.sigma):
        by_name.setdefault(p.replaces, []).append(p)
    for name, own in by_name.items():
        if len(own) == len(targets) > 1:
            sigma = PROBLEM.mean_within * min(p.sigma for p in own if p.sigma)
            yield Mean(name, tuple(p.name for p in own), sigma)
