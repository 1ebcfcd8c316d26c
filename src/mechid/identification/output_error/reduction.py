"""Reduction of a record to a triangle: QR of its weighted rows [Phi r J], block by block.

After all blocks, the rows of Phi (offset and drift, which are linear and projected out) are dropped. The remaining
triangle is that of [r J]: in its basis the residual is (||r||, 0, ..., 0), and the other columns are the Jacobian.
Memory does not grow with the record, and the condition number of J is not squared as in normal equations.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.output_error.jump_samples import Colour
from mechid.identification.output_error.misfit import Misfit, Model, Piece, Window, batch_misfits
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.kernel.compiled import aligned_zeros, compiled_module
from mechid.signal.trend import waves_at
from mechid.simulation.work import count, suspend_counting, work_counter


@lru_cache(maxsize=1)
def _reflections() -> ModuleType:
    """Return the compiled reflections, from the cache if they have been compiled before."""
    text = resources.files(__package__).joinpath("reflections.py").read_text(encoding="utf-8")
    # The digest of the text names the module, so that a changed text is compiled again.
    name = f"reflections_{hashlib.sha256(text.encode()).hexdigest()[:24]}"
    return compiled_module(name, lambda: text, lambda made: made.absorb(np.zeros((1, 1)), np.zeros((1, 1)), 0))


def absorb(R: FloatArray, block: FloatArray, n: int) -> None:
    """Update the triangle R, (m, m), with n further rows, stored as the columns of `block`, (m, >= n).

    Raises
    ------
    UsageError
        The reflections are not compiled yet, and the cache cannot be written to.
    """
    _reflections().absorb(R, block, n)


@dataclass(frozen=True)
class Triangle:
    """Reduced least-squares problem of one or more records.

    Attributes
    ----------
    norm : float
        ||r|| after projection, in units of sigma.
    jacobian : (1 + n, n)
        In the basis in which the residual is (norm, 0, ..., 0).
    samples : int
    """

    norm: float
    jacobian: FloatArray
    samples: int

    @property
    def cost(self) -> float:
        """Sum of squares, in units of sigma squared."""
        return self.norm**2

    @property
    def fun(self) -> FloatArray:
        """Residual in the triangle's basis, (1 + n,)."""
        out = np.zeros(self.jacobian.shape[0])
        out[0] = self.norm
        return out


def drop_projected_rows(R: FloatArray, linear: int, samples: int) -> Triangle:
    """Drop the first `linear` rows of a triangle of [Phi r J] and make the residual's entry positive."""
    rest = R[linear:, linear:]
    sign = -1.0 if rest[0, 0] < 0.0 else 1.0
    jacobian = rest[:, 1:].copy()
    jacobian[0] *= sign
    return Triangle(abs(float(rest[0, 0])), jacobian, samples)


def triangle_of_rows(r: FloatArray, J: FloatArray) -> Triangle:
    """Reduce given residuals, (k,), and their derivatives, (k, n)."""
    R = np.zeros((J.shape[1] + 1, J.shape[1] + 1))
    absorb(R, np.ascontiguousarray(np.column_stack([r, J]).T), r.size)
    return drop_projected_rows(R, 0, r.size)


def combine_triangles(triangles: list[Triangle]) -> Triangle:
    """Join the triangles of independent records into one."""
    n = triangles[0].jacobian.shape[1]
    stacked = np.vstack([np.column_stack([t.fun, t.jacobian]) for t in triangles])
    R = np.zeros((n + 1, n + 1))
    absorb(R, np.ascontiguousarray(stacked.T), stacked.shape[0])
    return drop_projected_rows(R, 0, sum(t.samples for t in triangles))


ROW_PADDING = 40
"""Unused numbers after each row, whole cache lines: the processor confuses addresses that are whole pages apart."""


class WeightedRows:
    """Blocks of the columns of [Phi r J] of a misfit's channels as rows, prefiltered, with excluded samples zeroed.

    Iteration yields (k, rows, n): n samples of channel k in rows[:, :n], which the next block overwrites. Offset and
    drift are filtered too. Zero are the first samples of a window, as many as the prefilter remembers, and rejected
    samples with as many after them: the whitening restarts after each gap. Nothing is divided by sigma.

    Attributes
    ----------
    energy_lost : list of float
        Reduction of each channel's sum of squared noise at jumps so far, in its variances.
    """

    def __init__(self, misfit: Misfit) -> None:
        self.misfit, self.window = misfit, misfit.window
        self.widths = [c.projected_columns + 1 + misfit.width for c in misfit.target.channels]
        self.energy_lost = [0.0] * len(self.widths)

    def __iter__(self) -> Iterator[tuple[int, FloatArray, int]]:
        channels = self.misfit.target.channels
        colours = [Colour.of(c.prefilter) for c in channels]
        memories = [np.zeros((width, c.order)) for width, c in zip(self.widths, channels, strict=True)]
        # Rows of the buffer are aligned and padded for the vectorised reflections.
        apart = self.misfit.run.block + ROW_PADDING
        buffers = [aligned_zeros(width * apart).reshape(width, apart) for width in self.widths]
        for piece in self.misfit:
            n = piece.samples
            for k, (channel, rows) in enumerate(zip(channels, buffers, strict=True)):
                self._write(rows, k, piece)
                # Phi, r and J are whitened together, so that offset and drift are still projected out exactly.
                if channel.prefilter is not None:
                    rows[:, :n], memories[k] = channel.prefilter.whiten_rows(rows[:, :n], memories[k])
                dropped = self._excluded_samples(channel, piece.first, n)
                rows[:, dropped] = 0.0
                self.energy_lost[k] += piece.jump_samples(k).energy_lost(colours[k], dropped)
                yield k, rows, n

    def _write(self, rows: FloatArray, k: int, piece: Piece) -> None:
        """Write the samples of a piece as rows."""
        n, channel = piece.samples, self.misfit.target.channels[k]
        write_removed(rows, channel, self.window, piece.first, n)
        piece.residual(k, rows[channel.projected_columns, :n])
        if self.misfit.width:
            piece.write_slopes(k, rows[channel.projected_columns + 1 :])

    def _excluded_samples(self, channel: TargetChannel, first: int, n: int) -> IntArray:
        """Return the excluded ones among n samples from `first` on."""
        order = channel.order
        beginning = np.arange(min(max(self.window[0] + order - first, 0), n))
        if not channel.rejected.size:
            return beginning
        # Samples before the piece matter too: the prefilter still remembers them.
        near = channel.rejected_within((first - order, first + n)) - order
        spoilt = (near[:, np.newaxis] + np.arange(order + 1)).ravel()
        return np.concatenate([beginning, spoilt[(spoilt >= 0) & (spoilt < n)]])


def write_removed(rows: FloatArray, channel: TargetChannel, window: tuple[int, int], first: int, n: int) -> None:
    """Write the projected columns as rows: offset, drift from -1 to 1 over the window, cosine and sine of lines."""
    if channel.linear > 0:
        rows[0, :n] = 1.0
    if channel.linear > 1:
        # Time is scaled to -1 to 1, which keeps the drift's column near the offset's in size and orthogonal to it.
        middle, half = 0.5 * sum(window), max(0.5 * (window[1] - window[0]), 1.0)
        rows[1, :n] = (np.arange(first, first + n) - middle) / half
    for j, pair in enumerate(waves_at(channel.turns, np.arange(first, first + n))):
        row = channel.linear + 2 * j
        rows[row, :n], rows[row + 1, :n] = pair


def reduce_channels(model: Model, target: Target, q: FloatArray, window: Window) -> tuple[list[FloatArray], bool]:
    """Return each channel's triangle of [Phi r J] in sigmas, and whether the simulation succeeded."""
    misfit = Misfit(model, target, q, window, jacobian=True)
    rows = WeightedRows(misfit)
    triangles = [np.zeros((width, width)) for width in rows.widths]
    for k, block, n in rows:
        absorb(triangles[k], block, n)
    _scale_to_sigmas(triangles, rows)
    return triangles, misfit.is_complete


def norms(model: Model, target: Target, points: Sequence[FloatArray], window: Window) -> list[float]:
    """Return ||r|| of a target in a window at several points, projected, in sigmas; inf if a simulation failed."""
    found = []
    for misfits in batch_misfits(model, [(target, q) for q in points], window):
        rows = [WeightedRows(misfit) for misfit in misfits]
        triangles = [[np.zeros((width, width)) for width in own.widths] for own in rows]
        for parts in zip(*rows, strict=True):
            for R, (k, block, n) in zip(triangles, parts, strict=True):
                absorb(R[k], block, n)
        for own, R in zip(rows, triangles, strict=True):
            _scale_to_sigmas(R, own)
        pairs = zip(misfits, triangles, strict=True)
        found += [_norm(target, window, R) if misfit.is_complete else np.inf for misfit, R in pairs]
    return found


def _scale_to_sigmas(triangles: Sequence[FloatArray], rows: WeightedRows) -> None:
    """Divide each channel's triangle of [Phi r J] by its noise, and add the noise lost at jumps.

    The lost noise is one more residual that no parameter changes. Without it, a model with many jumps would have a
    residual below the noise, whether the jumps are real or not, and a comparison of models would prefer it.
    """
    for R, channel, lost in zip(triangles, rows.misfit.target.channels, rows.energy_lost, strict=True):
        R[:, channel.projected_columns :] /= channel.scale
        if lost > 0.0:
            row = np.zeros((R.shape[0], 1))
            row[channel.projected_columns] = np.sqrt(lost)
            absorb(R, row, 1)


def _norm(target: Target, window: Window, triangles: Sequence[FloatArray]) -> float:
    each = []
    for channel, R in zip(target.channels, triangles, strict=True):
        # Offset, drift and lines are projected out of each channel separately.
        each.append(drop_projected_rows(R, channel.projected_columns, window[1] - window[0]).norm)
    return each[0] if len(each) == 1 else float(np.linalg.norm(each))


def triangle(model: Model, target: Target, q: FloatArray, window: Window) -> Triangle:
    """Return the reduced problem of a target in a window, for all its channels; NaN if the simulation failed."""
    each = channel_triangles(model, target, q, window)
    if each is None:
        size = model.coordinates.size
        lost = np.full((1 + size, size), np.nan)
        return Triangle(np.inf, lost, (window[1] - window[0]) * len(target.channels))
    return each[0] if len(each) == 1 else combine_triangles(each)


def channel_triangles(model: Model, target: Target, q: FloatArray, window: Window) -> list[Triangle] | None:
    """Return the reduced problem of each channel of a target in a window; None if the simulation failed."""
    triangles, succeeded = reduce_channels(model, target, q, window)
    if not succeeded:
        return None
    n = window[1] - window[0]
    return [drop_projected_rows(R, c.projected_columns, n) for c, R in zip(target.channels, triangles, strict=True)]


class TriangleCache:
    """Cache of the latest triangle of each record, which several parts of a search request at the same point.

    It belongs to one problem. Any other problem, even if only a weight differs, has its own cache, which starts empty.
    """

    def __init__(self) -> None:
        self._by_record: dict[str, tuple[tuple[Target, bytes, Window], Triangle, int]] = {}

    def of(self, model: Model, target: Target, q: FloatArray, window: Window) -> Triangle:
        """Return the triangle of a target at a point, computed unless it is the latest one.

        A cached triangle counts as the same work as a computed one, so that a resumed search, whose cache is empty,
        ends where the first one did.
        """
        key = target, q.tobytes(), window
        last = self._by_record.get(target.name)
        if last is not None and last[0] == key:
            count(last[2])
            return last[1]
        # The work is counted below, equally for cached and computed triangles.
        with suspend_counting(), work_counter() as own:
            found = triangle(model, target, q, window)
        count(own.done)
        self._by_record[target.name] = key, found, own.done
        return found
