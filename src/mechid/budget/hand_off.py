"""The budget as files: tables in CSV, and every number that is shown in budget.json."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechid.budget.budget import Budget, ModeBudget
from mechid.budget.hdf5 import is_available, write_hdf5
from mechid.budget.requirement import Standing
from mechid.campaign.toml_file import write_whole
from mechid.errors import UsageError
from mechid.identification.estimate_file import json_text
from mechid.signal.power import cumulative_rms

FORMAT = "mechid-budget/1"
HARMONICS, LINES, ENVELOPE = "harmonics.csv", "line_of_sight.csv", "envelope.csv"
CROSSINGS, JSON = "crossings.csv", "budget.json"
LOWEST_BAND_HZ, BANDS_PER_DECADE = 1.0, 10
"""Of the envelope: third octaves, as their tenth of a decade."""


def write_budget(budget: Budget, folder: Path | str) -> list[Path]:
    """Write the files of a budget into a folder, made where it is missing; each whole or not at all.

    Time series and densities go into disturbance.h5 where h5py is there.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder = Path(folder)
    texts = {
        HARMONICS: _harmonics(budget),
        LINES: _line_of_sight(budget),
        ENVELOPE: _envelope(budget),
        CROSSINGS: _crossings(budget),
        JSON: json_text(budget_data(budget)),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in texts.items():
            write_whole(folder / name, content)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written to ({error.strerror}); give another folder") from error
    files = [folder / name for name in texts]
    return [*files, write_hdf5(budget, folder)] if is_available() else files


def budget_data(budget: Budget) -> dict[str, Any]:
    """Return every number of the budget that is shown, as a plain dict."""
    return {
        "format": FORMAT,
        "estimate": str(budget.file.estimate),
        "structure": budget.file.structure.name,
        "line_of_sight": list(budget.file.structure.line_of_sight),
        "model_discrepancy": budget.estimate.discrepancy,
        "modes": [_mode(mode) for mode in budget.modes],
        "requirements": [_standing(s) for mode in budget.modes for s in mode.standings],
        "crossings": [vars(c) for c in budget.crossings],
        "warnings": list(budget.warnings),
    }


def _mode(budget: ModeBudget) -> dict[str, Any]:
    at = budget.responses[budget.worst]
    two_way = budget.two_way.rms().tolist() if budget.two_way else None
    density = _cumulative(budget)
    return {
        "name": budget.mode.name,
        "rates": budget.mode.rates.tolist(),
        "worst_rate": at.state.rate,
        "torque_rms_Nm": at.state.rms,
        "line_of_sight_rms_rad": at.rms().tolist(),
        "line_of_sight_rms_two_way_rad": two_way,
        "loop_gain": budget.loop_gain,
        "unsteady": at.state.unsteady,
        "uncovered": at.uncovered,
        "cumulative_rms_rad": density,
        "avoid": {name: [list(r) for r in ranges] for name, ranges in budget.avoid.items()},
    }


def _cumulative(budget: ModeBudget) -> dict[str, Any]:
    """Return RMS of all lines at or below each line, at the worst rate."""
    at = budget.responses[budget.worst]
    rms = np.sqrt(np.cumsum(0.5 * np.abs(at.phasors) ** 2, axis=0))
    out: dict[str, Any] = {"frequency_Hz": at.state.frequency_hz.tolist(), "lines": rms.T.tolist()}
    if at.frequency_hz is not None and at.density is not None:
        parts = [cumulative_rms(at.frequency_hz, column)[-1] for column in at.density.T]
        out["random_total"] = [float(part) for part in parts]
    return out


def _standing(s: Standing) -> dict[str, Any]:
    r = s.requirement
    return {
        "requirement": r.name, "mode": s.mode, "index": r.index.kind, "window_s": r.index.window_s,
        "separation_s": r.index.separation_s, "axis": r.axis, "interpretation": r.interpretation,
        "confidence": r.confidence, "evaluation_period_s": r.evaluation_period_s, "limit_rad": r.limit_rad,
        "level_rad": s.level.value, "sigma_rad": s.level.sigma, "ci95_rad": list(s.level.ci95),
        "ecss_summation_rad": s.ecss_rad, "margin": s.margin, "margin95": list(s.margin95), "met": s.met,
        "variance_shares": dict(sorted(s.level.shares.items(), key=lambda item: -abs(item[1]))),
    }  # fmt: skip


def _harmonics(budget: Budget) -> Iterator[str]:
    """Yield the torque's lines: rate, order a full step, amplitude, phase, and the amplitude's sigma."""
    yield "mode,rate_steps_per_s,order,frequency_Hz,torque_amplitude_Nm,phase_deg,sigma_Nm\n"
    n = len(budget.estimate.names)
    for mode in budget.modes:
        for response in mode.responses:
            s = response.state
            unit = np.conj(s.lines) / np.maximum(np.abs(s.lines), 1e-300)
            slope = (unit[:, None] * s.gradient[:, :n]).real
            own = np.einsum("ij,jk,ik->i", slope, budget.estimate.covariance, slope)
            sigma = np.sqrt(np.maximum(own, 0.0) + (budget.estimate.discrepancy * np.abs(s.lines)) ** 2)
            for order, f, line, error in zip(0.5 * s.orders, s.frequency_hz, s.lines, sigma, strict=True):
                phase = np.degrees(np.angle(line))
                yield f"{mode.mode.name},{s.rate:.9g},{order:g},{f:.9g},{abs(line):.9e},{phase:.4f},{error:.3e}\n"


def _line_of_sight(budget: Budget) -> Iterator[str]:
    axes = budget.file.structure.line_of_sight
    yield "mode,rate_steps_per_s," + ",".join(f"rms_{axis}_rad" for axis in axes) + "\n"
    for mode in budget.modes:
        for response in mode.responses:
            rms = ",".join(f"{value:.9e}" for value in response.rms())
            yield f"{mode.mode.name},{response.state.rate:.9g},{rms}\n"


def _envelope(budget: Budget) -> Iterator[str]:
    """Yield the largest torque line in each band at any rate, mode by mode."""
    yield "mode,from_Hz,to_Hz,torque_amplitude_Nm\n"
    for mode in budget.modes:
        decades = np.log10(mode.mode.highest_hz / LOWEST_BAND_HZ)
        edges = LOWEST_BAND_HZ * 10.0 ** (np.arange(np.ceil(decades * BANDS_PER_DECADE) + 1) / BANDS_PER_DECADE)
        for low, high, size in zip(edges, edges[1:], mode.order_map.envelope(edges), strict=False):
            yield f"{mode.mode.name},{low:.6g},{high:.6g},{size:.9e}\n"


def _crossings(budget: Budget) -> Iterator[str]:
    yield "rate_steps_per_s,order,mode,frequency_Hz\n"
    for c in budget.crossings:
        yield f"{c.rate:.9g},{c.order:g},{c.mode},{c.frequency_hz:.9g}\n"
