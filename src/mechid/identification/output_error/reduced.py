"""One record reduced: its misfit at a point, weighted and freed of what is projected out, as triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Misfit, Window, side_by_side
from mechid.identification.output_error.model import Model
from mechid.identification.output_error.reduction import Triangle, absorb, combined, finished
from mechid.identification.output_error.target import Target
from mechid.identification.output_error.weighted_rows import WeightedRows


def reduced(model: Model, target: Target, q: FloatArray, window: Window) -> tuple[list[FloatArray], bool]:
    """Return each channel's triangle of [Phi r J] in sigmas, and whether the simulation succeeded."""
    misfit = Misfit(model, target, q, window, jacobian=True)
    rows = WeightedRows(misfit)
    triangles = [np.zeros((width, width)) for width in rows.widths]
    for k, block, n in rows:
        absorb(triangles[k], block, n)
    _into_sigmas(triangles, rows)
    return triangles, misfit.succeeded


def norms(model: Model, target: Target, points: Sequence[FloatArray], window: Window) -> list[float]:
    """Return ||r|| of a target in a window at several points, projected, in sigmas; inf where a simulation failed."""
    found = []
    for misfits in side_by_side(model, [(target, q) for q in points], window):
        rows = [WeightedRows(misfit) for misfit in misfits]
        triangles = [[np.zeros((width, width)) for width in own.widths] for own in rows]
        for parts in zip(*rows, strict=True):
            for R, (k, block, n) in zip(triangles, parts, strict=True):
                absorb(R[k], block, n)
        for own, R in zip(rows, triangles, strict=True):
            _into_sigmas(R, own)
        pairs = zip(misfits, triangles, strict=True)
        found += [_norm(target, window, R) if misfit.succeeded else np.inf for misfit, R in pairs]
    return found


def _into_sigmas(triangles: Sequence[FloatArray], rows: WeightedRows) -> None:
    """Divide each channel's triangle of [Phi r J] by its noise, and put in what the noise lost at jumps.

    That is one more residual, which no parameter moves. Without it a model with many jumps would leave less than the
    noise, be they there or not, and a comparison of models would favour it.
    """
    for R, channel, lost in zip(triangles, rows.misfit.target.channels, rows.energy_lost, strict=True):
        R[:, channel.removed :] /= channel.scale
        if lost > 0.0:
            row = np.zeros((R.shape[0], 1))
            row[channel.removed] = np.sqrt(lost)
            absorb(R, row, 1)


def _norm(target: Target, window: Window, triangles: Sequence[FloatArray]) -> float:
    each = []
    for channel, R in zip(target.channels, triangles, strict=True):
        each.append(finished(R, channel.removed, window[1] - window[0]).norm)
    return each[0] if len(each) == 1 else float(np.linalg.norm(each))


def triangle(model: Model, target: Target, q: FloatArray, window: Window) -> Triangle:
    """Return the reduced problem of a target in a window, of all its channels together; NaN where it failed."""
    each = channel_triangles(model, target, q, window)
    if each is None:
        size = model.coordinates.size
        lost = np.full((1 + size, size), np.nan)
        return Triangle(np.inf, lost, (window[1] - window[0]) * len(target.channels))
    return each[0] if len(each) == 1 else combined(each)


def channel_triangles(model: Model, target: Target, q: FloatArray, window: Window) -> list[Triangle] | None:
    """Return the reduced problem of each channel of a target in a window; None where the simulation failed."""
    triangles, succeeded = reduced(model, target, q, window)
    if not succeeded:
        return None
    n = window[1] - window[0]
    return [finished(R, c.removed, n) for c, R in zip(target.channels, triangles, strict=True)]


class LatestTriangles:
    """The triangle of each record where it was last reduced: an end is looked at from several sides.

    It belongs to one problem. Another problem, be it by a weight alone, has another one, which begins empty.
    """

    def __init__(self) -> None:
        self._by_record: dict[str, tuple[tuple[Target, bytes, Window], Triangle]] = {}

    def of(self, model: Model, target: Target, q: FloatArray, window: Window) -> Triangle:
        """Return the triangle of a target at a point, worked out unless it is the one that was worked out last."""
        key = target, q.tobytes(), window
        last = self._by_record.get(target.name)
        if last is None or last[0] != key:
            last = key, triangle(model, target, q, window)
            self._by_record[target.name] = last
        return last[1]
