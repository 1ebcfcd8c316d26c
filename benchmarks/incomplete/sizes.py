"""Families of benches: which effects they draw, of what sizes, and in which test runs they show."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from incomplete import by_events, plant
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
    simulators : tuple of callable
        Each takes its turn, seed by seed.
    tells_more : bool
        Whether truth.json has what each record was drawn with, the simulator, how far the effect shows, and how long
        each record can be predicted.
    """

    name: str
    effects: Mapping[str, Effect]
    runs: Callable[[Mechanism, np.random.Generator], dict[str, Run]]
    simulators: tuple[Simulate, ...] = (plant.run,)
    tells_more: bool = True

    def simulator(self, seed: int) -> Simulate:
        """Return the simulator of a seed."""
        return self.simulators[seed % len(self.simulators)]


SMALL = Sizes("", EFFECTS, lambda mechanism, _: runs_of(mechanism), tells_more=False)
SIZES = {
    "small": SMALL,
    "hardware": Sizes("hardware", HARDWARE, runs_at_resonance, (*[plant.run] * 4, by_events.run)),
}
"""By the name that an option has. One seed in five of the second is by the second simulator."""
