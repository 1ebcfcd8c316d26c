"""A task as the entries read it: records, catalogue, bounds, and the clock that ends a method after its CPU time."""

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

MOST_CPU_S = 300.0
"""CPU time of one method on one campaign; its best point until then is entered."""


@dataclass(frozen=True)
class Task:
    """One campaign.

    Attributes
    ----------
    table : mapping
        Contents of task.json.
    records : mapping of str to (N,)
        Torque of each record, N m.
    names : tuple of str
        Asked parameters; the arrays below are in this order.
    catalogue, low, high : (P,)
    """

    table: Mapping[str, Any]
    records: Mapping[str, np.ndarray]
    names: tuple[str, ...]
    catalogue: np.ndarray
    low: np.ndarray
    high: np.ndarray


def read_task(folder: Path) -> Task:
    """Return the task in a folder."""
    table = json.loads((folder / "task.json").read_text())
    records = {
        name: np.loadtxt(folder / one["file"], delimiter=",", skiprows=1, usecols=1)
        for name, one in table["records"].items()
    }
    columns = (np.array([one[key] for one in table["asked"].values()]) for key in ("catalogue", "min", "max"))
    return Task(table, records, tuple(table["asked"]), *columns)


class TimeSpentError(Exception):
    """The CPU time of a method is spent."""


@dataclass
class Clock:
    """CPU time since a method began."""

    began: float = field(default_factory=time.process_time)

    @property
    def seconds(self) -> float:
        """CPU time so far."""
        return time.process_time() - self.began

    def check(self) -> None:
        """Raise TimeSpentError where the time is spent."""
        if self.seconds > MOST_CPU_S:
            raise TimeSpentError


def without_line(series: np.ndarray) -> np.ndarray:
    """Return a series, (N,) or (N, P), less the offset and drift that fit it best."""
    n = series.shape[0]
    t = np.linspace(-1.0, 1.0, n)
    return series - series.mean(axis=0) - np.multiply.outer(t, t @ series / (t @ t))


def entry_of(values: np.ndarray, half_widths: np.ndarray | None, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the parameters as a submission holds them, with intervals where there are finite half-widths."""
    table = {name: {"value": float(value)} for name, value in zip(names, values, strict=True)}
    if half_widths is not None:
        for own, half in zip(table.values(), half_widths, strict=True):
            if np.isfinite(half):
                own["interval"] = [own["value"] - float(half), own["value"] + float(half)]
    return table


def half_widths_of(J: np.ndarray, residual: np.ndarray) -> np.ndarray | None:
    """Return half-widths of 95 % intervals by the usual formula for white residuals; None for a singular Jacobian."""
    scale = np.linalg.norm(J, axis=0)
    if not np.all(scale > 0.0):
        return None
    R = np.linalg.qr(J / scale, mode="r")
    if np.linalg.cond(R) > 1e10:
        return None
    inverse = np.linalg.inv(R)
    variance = residual @ residual / (residual.size - J.shape[1])
    return 1.96 * np.sqrt(variance * np.sum(inverse**2, axis=1)) / scale
