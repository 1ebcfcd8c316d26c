"""Families of benches: which effects they draw, of what sizes, and in which test runs they show."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from incomplete import plant
from incomplete.effects import EFFECTS, Effect
from incomplete.hardware import HARDWARE, runs_at_resonance
from incomplete.recording import Run, Simulate, runs_of
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True)
class Sizes:
    """A family of benches.

    Attributes
    ----------
    name : str
        Empty for the first family, so that its random streams stay those of the effect's name alone.
    effects : mapping of str to Effect
    runs : callable
        From a mechanism and a generator to the test runs by name.
    tells_more : bool
        Whether truth.json has what each record was drawn with, the simulator, and how far the effect shows.
    """

    name: str
    effects: Mapping[str, Effect]
    runs: Callable[[Mechanism, np.random.Generator], dict[str, Run]]
    tells_more: bool = True

    def simulator(self, seed: int) -> tuple[str, Simulate]:
        """Return name and function of the simulator of a seed."""
        return "plant", plant.run


SMALL = Sizes("", EFFECTS, lambda mechanism, _: runs_of(mechanism), tells_more=False)
SIZES = {"small": SMALL, "hardware": Sizes("hardware", HARDWARE, runs_at_resonance)}
"""By the name that an option has."""
