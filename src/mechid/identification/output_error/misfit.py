"""Model at a point, simulated under a record's command, and its misfit to the measurement.

r = model - measured, in the channel's SI unit. It is the residual of the least squares, so dr/dq is dy/dq, and lines
are projected out of r. Reported values have the other sign, measured = model + offset + drift t: the sign is changed
where a result is built, in `result.record_fit`, and nowhere below.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import is_of_start, key_in_record
from mechid.identification.output_error.coordinates import Coordinates
from mechid.identification.output_error.jump_samples import NO_SAMPLES, JumpSamples, samples_at
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.target import Target, is_clock
from mechid.kernel.batch.source import SETS
from mechid.signal.stored_series import WritableSeries, allocate_series
from mechid.simulation.batch import Batch
from mechid.simulation.block import Block
from mechid.simulation.divided import DividedRun
from mechid.simulation.shared_runs import SHARED_RUNS, Blocks
from mechid.simulation.simulator import Run, Simulator
from mechid.simulation.start import Start
from mechid.simulation.time_scale import start_slopes
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import RUNS_A_BATCH


@dataclass(frozen=True, eq=False)
class Model:
    """Mechanism at any point of its coordinates, with `substeps` integration steps per sample.

    It keeps no state between runs: the kernel is compiled once for all, and the step edges belong to the targets.
    The directions of a run with derivatives are shared among `threads` threads, with the same values to the last bit.
    """

    coordinates: Coordinates
    substeps: int = 1
    threads: int = 1

    def output(self, quantity: str) -> int:
        """Return the index of a quantity among the plant's outputs."""
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
        """Start the simulation of the first `stop` samples of a target at `q`.

        It logs at most `events` switches or jumps.
        """
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

    def run_with_derivatives(self, target: Target, q: FloatArray, stop: int, *, block: int | None = None) -> Blocks:
        """Start the simulation with derivatives of the first `stop` samples, on `threads` threads."""
        if self.threads == 1:
            return self.run(target, q, stop, jacobian=True, block=block)
        at, simulator = self.coordinates, self._simulator(target, self._start(target, q, carried=True))
        own: dict[str, Any] = {
            "timing": at.timing(target, q),
            "substeps": self.substeps,
            "samples": stop,
            "block": block,
        }
        return DividedRun(simulator, at.kernel(target, q), at.directions(target, q), self.threads, events=None, **own)

    def shared_run(self, target: Target, q: FloatArray, stop: int, *, block: int | None = None) -> Blocks:
        """Start the simulation without derivatives of the first `stop` samples, or repeat it if it is a latest one."""
        at = self.coordinates
        return SHARED_RUNS.begin(
            self._simulator(target, self._start(target, q, carried=False)),
            at.kernel(target, q),
            timing=at.timing(target, q),
            substeps=self.substeps,
            block=block,
            samples=stop,
        )

    def plain_runs(self, target: Target, points: Sequence[FloatArray], stop: int) -> list[Run]:
        """Start simulations of the first `stop` samples of a target at several points, without derivatives."""
        if any(is_of_start(p) for p in target.own):
            return [self.run(target, q, stop) for q in points]
        simulator, at = self._simulator(target, self._start(target, points[0], carried=False)), self.coordinates
        # Points share one map of time if the target has no free parameters of its own.
        same = None if target.free_parameters else at.timing(target, points[0])
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
        """Return the start of a target's run at `q`, with the lanes that carry derivatives if `carried`."""
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
        """Return the model's value of each channel over the first `stop` samples, (stop,); NaN after a failure."""
        y = tuple(np.empty(min(stop, target.samples)) for _ in target.channels)
        outputs = [self.output(quantity) for quantity in target.quantities]
        for block in self.shared_run(target, q, stop).blocks():
            for values, j in zip(y, outputs, strict=True):
                values[block.start : block.stop] = block.y[:, j]
        return y


Window = tuple[int, int]
"""First and last-plus-one sample."""


def residual(modelled: FloatArray, measured: FloatArray, out: FloatArray | None = None) -> FloatArray:
    """Return model minus measured, (n,): the only subtraction of the two in an identification."""
    # Only one place fixes the sign, so that residual and derivatives cannot disagree.
    return np.subtract(modelled, measured, out=out)


class Misfit:
    """Misfit of a target's channels at a point over a window, piece by piece; it can be iterated once.

    Parameters
    ----------
    model : Model
    target : Target
    q : (n,)
    window : (int, int)
    jacobian : bool
        Whether to compute derivatives.
    block : int or None
        Samples simulated at once; None leaves the choice to the simulator.
    run : Blocks or None
        The simulation, if it has already been started.
    """

    def __init__(
        self,
        model: Model,
        target: Target,
        q: FloatArray,
        window: Window,
        *,
        jacobian: bool = False,
        block: int | None = None,
        run: Blocks | None = None,
    ) -> None:
        self.coordinates, self.target, self.window = model.coordinates, target, window
        self.width = self.coordinates.size if jacobian else 0
        self.outputs = [model.output(quantity) for quantity in target.quantities]
        if run is None and jacobian:
            run = model.run_with_derivatives(target, q, window[1], block=block)
        self.run: Blocks = run or model.shared_run(target, q, window[1], block=block)

    @property
    def is_complete(self) -> bool:
        """Whether the simulation reached the window's end; known after the iteration."""
        return self.run.outcome is SimulationOutcome.COMPLETE

    def __iter__(self) -> Iterator[Piece]:
        for block in self.run.blocks():
            first = max(block.start, self.window[0])
            if first < block.stop:
                yield Piece(self, block, first)


def batch_misfits(model: Model, pairs: Sequence[tuple[Target, FloatArray]], window: Window) -> Iterator[list[Misfit]]:
    """Yield misfits without derivatives in groups whose pieces must be iterated in step.

    Each misfit is of a target at a point; the targets differ only in their measured samples. A group is simulated as a
    batch, unless it is so small or so short that little would be gained.
    """
    for first in range(0, len(pairs), SETS):
        group = pairs[first : first + SETS]
        if len(group) == 1:
            yield [Misfit(model, *group[0], window)]
            continue
        initial = model.plain_runs(group[0][0], [q for _, q in group], window[1])
        alike = len(initial) >= PROBLEM.fewest_in_batch and all(
            r.outcome is SimulationOutcome.COMPLETE for r in initial
        )
        runs: Sequence[Blocks] = initial
        if alike and window[1] >= PROBLEM.shortest_in_batch:
            runs = Batch(initial).each(window[0])
        elif alike:
            # Limits of work were set while short runs were batched, so these still count as in a batch.
            for run in initial:
                run.runs_counted_as_one = RUNS_A_BATCH
        yield [Misfit(model, *pair, window, run=run) for pair, run in zip(group, runs, strict=True)]


def misfit_series(model: Model, target: Target, q: FloatArray, window: Window) -> tuple[WritableSeries, ...]:
    """Return r of each channel over a window, n samples; NaN from the first failed sample on."""
    return misfit_series_of(model, target, [q], window)[0]


def misfit_series_of(
    model: Model, target: Target, points: Sequence[FloatArray], window: Window
) -> list[tuple[WritableSeries, ...]]:
    """Return the series of `misfit_series` at several points."""
    first, stop = window[0], min(window[1], target.samples)
    found = [tuple(allocate_series(max(stop - first, 0)) for _ in target.channels) for _ in points]
    waiting = iter(found)
    for group in batch_misfits(model, [(target, q) for q in points], window):
        own = [next(waiting) for _ in group]
        for pieces in zip(*group, strict=True):
            for piece, series in zip(pieces, own, strict=True):
                for k, r in enumerate(series):
                    r[piece.first - first : piece.stop - first] = piece.residual(k)
    return found


@dataclass(frozen=True, eq=False)
class Piece:
    """Samples `first` to `stop` of all channels of a target and of the model; the next piece overwrites it.

    Attributes
    ----------
    misfit : Misfit
    block : Block
        Simulated block; the piece is its end.
    first : int
    """

    misfit: Misfit
    block: Block
    first: int
    _jump_samples: dict[int, JumpSamples] = field(default_factory=dict)

    @property
    def stop(self) -> int:
        """Last sample, plus one."""
        return self.block.stop

    @property
    def samples(self) -> int:
        """Number of samples, n."""
        return self.block.stop - self.first

    def residual(self, k: int, out: FloatArray | None = None) -> FloatArray:
        """Return r of channel k, (n,), with samples at jumps pulled towards the mean of their neighbours."""
        modelled = self.block.y[-self.samples :, self.misfit.outputs[k]]
        r = residual(modelled, self.misfit.target.channels[k].measured[self.first : self.stop], out)
        self.jump_samples(k).draw(r)
        return r

    def write_slopes(self, k: int, rows: FloatArray) -> None:
        """Write dr/dq of channel k as rows, (size, >= n), with samples at jumps treated as in `residual`."""
        at, own = self.misfit.coordinates, self.misfit
        at.write_slopes(rows, own.target, own.outputs[k], self.block, self.samples)
        self.jump_samples(k).draw(rows)

    def jump_samples(self, k: int) -> JumpSamples:
        """Return the samples of channel k next to jumps of the model."""
        jumps = self.block.jumps
        if not jumps.samples.size:
            return NO_SAMPLES
        if k not in self._jump_samples:
            rises = jumps.rises[:, self.misfit.outputs[k]] / self.misfit.target.channels[k].sigma
            # Residual and slopes of a piece use the same samples.
            self._jump_samples[k] = samples_at(jumps.shift_by(self.block.start), rises, self.first, self.samples)
        return self._jump_samples[k]
