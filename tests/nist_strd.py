"""The nonlinear regression problems of NIST's Statistical Reference Datasets, read from their own files.

https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml: model, data, two starts, and certified values.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sympy as sp

from mechid.identification.output_error.reduction import Triangle, absorb, drop_projected_rows

_NAMES = """
    Bennett5 BoxBOD Chwirut1 Chwirut2 DanWood ENSO Eckerle4 Gauss1 Gauss2 Gauss3 Hahn1 Kirby2 Lanczos1 Lanczos2 Lanczos3
    MGH09 MGH10 MGH17 Misra1a Misra1b Misra1c Misra1d Nelson Rat42 Rat43 Roszman1 Thurber
"""
NAMES = tuple(_NAMES.split())
CERTIFIED_DIGITS = 11


@dataclass(frozen=True)
class Regression:
    """A problem: its model and derivatives compiled, its data, starts (2, k) and certified values."""

    model: object
    derivatives: object
    x: np.ndarray
    y: np.ndarray
    starts: np.ndarray
    certified: np.ndarray
    certified_errors: np.ndarray
    certified_sum: float

    @property
    def freedom(self):
        return self.y.size - self.certified.size

    def norm(self, b):
        """Return ||model - y||, not finite where the model is not."""
        with np.errstate(all="ignore"):
            return float(np.linalg.norm(self.model(b, self.x) - self.y))

    def triangle(self, b):
        """Return [r J] reduced as mechid reduces a record."""
        with np.errstate(all="ignore"):
            columns = [self.model(b, self.x) - self.y, *self.derivatives(b, self.x)]
        rows = np.array([np.broadcast_to(column, self.y.shape) for column in columns], dtype=float)
        if not np.all(np.isfinite(rows)):
            return Triangle(np.inf, np.full((b.size + 1, b.size), np.nan), self.y.size)
        R = np.zeros((b.size + 1, b.size + 1))
        absorb(R, rows, self.y.size)
        return drop_projected_rows(R, 0, self.y.size)


def read(path: Path) -> Regression:
    """Read a problem; its derivatives are SymPy's."""
    lines = path.read_text().splitlines()
    left, right = _equation(lines)
    table = np.array([line.split("=")[1].split() for line in lines if re.match(r"\s*b\d+ =", line)], dtype=float)
    data = np.array([line.split() for line in lines[_last(lines, "Data:") + 1 :] if line.strip()], dtype=float)
    b = sp.symbols(f"b1:{len(table) + 1}")
    x = sp.symbols("x1 x2") if data.shape[1] == 3 else (sp.Symbol("x"),)
    model = sp.sympify(right, locals={str(s): s for s in (*b, *x)})
    return Regression(
        model=sp.lambdify((b, x), model, "numpy"),
        derivatives=sp.lambdify((b, x), [sp.diff(model, q) for q in b], "numpy"),
        x=data[:, 1:].T,
        y=np.log(data[:, 0]) if left.startswith("log") else data[:, 0],
        starts=table[:, :2].T,
        certified=table[:, 2],
        certified_errors=table[:, 3],
        certified_sum=float(lines[_last(lines, "Residual Sum")].split(":")[1]),
    )


def _equation(lines):
    """Return both sides of the model, the right one as Python writes it."""
    begin = _last(lines, "Model:") + 2
    count = next(i for i, line in enumerate(lines[begin:]) if re.match(r"\s*starting values", line, re.IGNORECASE))
    body = [line.strip() for line in lines[begin : begin + count]]
    left, right = " ".join(line for line in body if line and not line.startswith("pi =")).split("=", 1)
    right = re.sub(r"\+\s*e\s*$", "", right.strip())
    return left.strip(), right.replace("[", "(").replace("]", ")").replace("arctan", "atan")


def _last(lines, begin):
    return max(i for i, line in enumerate(lines) if line.startswith(begin))


def digits(found, certified):
    """Return the least number of digits to which values agree with certified ones."""
    error = np.abs(np.asarray(found) - certified) / np.abs(certified)
    return float(np.min(-np.log10(np.maximum(error, 10.0**-CERTIFIED_DIGITS))))
