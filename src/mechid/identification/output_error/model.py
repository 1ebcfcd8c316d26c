"""The model at any point of the coordinates: one plant, run under the command of one record after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import is_of_start, key_in_record
from mechid.identification.output_error.coordinates import Coordinates
from mechid.identification.output_error.target import Target, is_clock
from mechid.simulation.simulator import Run, Simulator
from mechid.simulation.start import Start
from mechid.simulation.time_scale import start_slopes


@dataclass(frozen=True, eq=False)
class Model:
    """What the mechanism does at a point of its coordinates, with `substeps` integration steps a sample.

    It remembers nothing of its runs: the kernel is compiled once for all, and a record's step edges are its target's.
    """

    coordinates: Coordinates
    substeps: int = 1

    def output(self, quantity: str) -> int:
        """Return which of the plant's outputs a quantity is."""
        return tuple(self.coordinates.space.mechanism.plant.outputs).index(quantity)

    def run(
        self,
        target: Target,
        q: FloatArray,
        stop: int,
        *,
        jacobian: bool = False,
        events: int | None = None,
        block: int | None = None,
    ) -> Run:
        """Begin the simulation of the first `stop` samples of a target at `q`; it logs so many switches, or jumps."""
        at, timing = self.coordinates, self.coordinates.timing(target, q)
        return self._simulator(target, self._start(target, q, carried=jacobian)).run(
            at.kernel(target, q),
            timing=timing,
            substeps=self.substeps,
            directions=at.directions(target, q) if jacobian else None,
            samples=stop,
            events=events,
            block=block,
        )

    def plain_runs(self, target: Target, points: Sequence[FloatArray], stop: int) -> list[Run]:
        """Begin the simulations of the first `stop` samples of a target at several points, without derivatives."""
        if any(is_of_start(p) for p in target.own):
            return [self.run(target, q, stop) for q in points]
        simulator, at = self._simulator(target, self._start(target, points[0], carried=False)), self.coordinates
        same = None if target.moved else at.timing(target, points[0])
        timings = [same or at.timing(target, q) for q in points]
        return [
            simulator.run(
                at.kernel(target, q),
                timing=timing,
                substeps=self.substeps,
                samples=stop,
                events=None,
            )
            for q, timing in zip(points, timings, strict=True)
        ]

    def _simulator(self, target: Target, start: Start) -> Simulator:
        at = self.coordinates
        return Simulator(
            at.space.mechanism.plant,
            target.command,
            target.base,
            capacity=at.lanes,
            known_edges=target.excitation,
            start=start,
        )

    def _start(self, target: Target, q: FloatArray, *, carried: bool) -> Start:
        """Return where the run of a target begins at `q`, with the lanes that carry derivatives where `carried`."""
        at = self.coordinates
        own = Start({key_in_record(p.name): at.value(p, q) for p in target.own if is_of_start(p)})
        if not carried or not own.values:
            return own
        free = {c.lane: c.parameter for c in at.of(target) if c.lane is not None}
        lanes = {n: {key_in_record(p.name): 1.0} for n, p in free.items() if is_of_start(p)}
        clocks = [n for n, p in free.items() if is_clock(p)]
        slopes = start_slopes(at.space.mechanism.plant, own, at.timing(target, q)) if clocks else {}
        return replace(own, lanes={**lanes, **dict.fromkeys(clocks, slopes)})

    def predict(self, target: Target, q: FloatArray, stop: int) -> tuple[FloatArray, ...]:
        """Return what the model gives of each channel over the first `stop` samples, (stop,); NaN where it failed."""
        y = tuple(np.empty(min(stop, target.samples)) for _ in target.channels)
        outputs = [self.output(quantity) for quantity in target.quantities]
        for block in self.run(target, q, stop).blocks():
            for values, j in zip(y, outputs, strict=True):
                values[block.start : block.stop] = block.y[:, j]
        return y
