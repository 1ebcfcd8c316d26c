"""Results of a budget as one plain dict, which all outputs share."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.budget import BY_DUTY, Budget
from mechid.budgets.coupling import loop_gain
from mechid.budgets.course_numbers import course_of
from mechid.budgets.hdf5 import line_of_sight_series
from mechid.budgets.line_of_sight import Response
from mechid.budgets.margins import margins
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.named_lines import named_line_numbers
from mechid.budgets.named_modes import named_modes
from mechid.budgets.origin import origin_numbers
from mechid.budgets.over_rate import torque_bands
from mechid.budgets.prediction_numbers import exported_numbers
from mechid.budgets.requirement import Standing
from mechid.budgets.settings import LEVEL, RESIDUALS
from mechid.budgets.side_numbers import side_of_bench, side_of_mode
from mechid.budgets.steadiness import steadiness
from mechid.signal.power import cumulative_rms

FORMAT = "mechid-budget/1"
LOWEST_BAND_HZ, BANDS_PER_DECADE = 1.0, 10
"""Bands of the envelope: a third octave is taken as a tenth of a decade."""
SHOWN_S, SHOWN_SAMPLES = 0.25, 1500
"""Length of the line of sight over time, and its largest number of samples."""
GAIN_POINTS = 500


def budget_numbers(budget: Budget) -> dict[str, Any]:
    """Return every result of the budget as a plain dict that JSON can hold."""
    file = budget.file
    return {
        "format": FORMAT,
        "file": file.path.name,
        "estimate": str(file.estimate),
        "synthetic": budget.estimate.synthetic,
        "structure": file.structure.name,
        "line_of_sight": list(file.structure.line_of_sight),
        "model_discrepancy": budget.estimate.discrepancy.overall,
        "model_discrepancy_by_order": [[q, e] for q, e in sorted(budget.estimate.discrepancy.orders.items())],
        "residual_known": budget.estimate.residual is not None,
        **side_of_bench(budget.side),
        "flight": {
            "values": dict(file.flight.values),
            "uncertain": dict(file.flight.uncertain),
            "spread": dict(file.flight.spread),
            "load_modes": [vars(mode) for mode in file.flight.load_modes],
            "left_on_bench": dict(budget.estimate.left),
        },
        "modes": [_mode(budget, made) for made in budget.modes],
        "requirements": [_standing_numbers(budget, s) for s in budget.standings],
        "emission_requirements": [exported_numbers(one) for one in budget.predictions],
        "errors": [
            {
                "name": e.name,
                "kind": e.kind,
                "size_rad": e.size_rad,
                "spread_rad": e.spread_rad,
                "group": e.group,
                "axes": [n for n, on in zip(file.structure.line_of_sight, e.axes, strict=True) if on],
                "frequency_hz": e.frequency_hz,
                "bandwidth_hz": e.bandwidth_hz,
            }
            for e in file.errors
        ],
        "named_modes": [{"name": n, "frequency_hz": f} for n, f in named_modes(file.structure, budget.estimate)],
        "campbell_orders": list(LEVEL.campbell_orders),
        "crossings": [vars(c) for c in budget.crossings],
        "coupling": _coupling_numbers(budget),
        "notes": _notes(budget),
        "warnings": list(budget.warnings),
        **origin_numbers(budget.estimate.origin, budget.estimate.digest, file.inputs),
    }


def _notes(budget: Budget) -> list[str]:
    return [f"left on the bench: {name}: {reason}" for name, reason in budget.estimate.left.items()]


def _coupling_numbers(budget: Budget) -> dict[str, Any]:
    """Return |receptance x dynamic stiffness| over the frequency, and the criterion."""
    file = budget.file
    low, high = file.structure.coverage_hz
    top = min(max(mode.highest_hz for mode in file.modes), high)
    frequency = np.geomspace(max(low, 1.0), max(top, 2.0), GAIN_POINTS)
    gains = loop_gain(file.structure, budget.estimate.mechanism, frequency)
    at_lines = [made.loop_gain for made in budget.modes if not math.isnan(made.loop_gain)]
    return {
        "suffices_below": RESIDUALS.suffices,
        "frequency_hz": frequency.tolist(),
        "loop_gain": gains.tolist(),
        "largest_at_lines": max(at_lines, default=math.nan),
        "joined_below_hz": file.coupled_below_hz,
    }


def _mode(budget: Budget, made: ModeBudget) -> dict[str, Any]:
    mode = made.mode
    return {
        "name": mode.name,
        "kind": "profile" if mode.is_profile else "steady",
        "stepping": mode.command.stepping,
        "microsteps": mode.command.microsteps,
        "duty": mode.duty,
        "rates": mode.rates.tolist(),
        "loop_gain": made.loop_gain,
        "two_way_level_rad": {name: level for name, (_, level) in made.two_way_levels.items()},
        "avoid": {name: [list(r) for r in ranges] for name, ranges in made.avoid.items()},
        **(course_of(budget, made, made.course) if made.course is not None else _steady(budget, made)),
    }


def _steady(budget: Budget, made: ModeBudget) -> dict[str, Any]:
    at = made.responses[made.worst]
    two_way = made.two_way[made.worst].rms().tolist() if made.two_way else None
    return {
        "worst_rate": at.state.rate,
        "torque_rms_Nm": at.state.rms,
        "torque_rms_error_Nm": at.state.rms_error,
        "line_of_sight_rms_rad": at.rms().tolist(),
        "line_of_sight_rms_lacking_rad": at.residual_rms().tolist(),
        "line_of_sight_rms_two_way_rad": two_way,
        "unsteady": at.state.unsteady,
        "steady_states": steadiness(made),
        "uncovered": at.uncovered,
        "cumulative_rms_rad": _cumulative(at),
        "map": _map(made),
        "envelope": _envelope(budget, made),
        "emission": _emission(made),
        "over_rate": _over_rate(made),
        "series": _series(made),
        "lines": _lines(made),
        "named_lines": named_line_numbers(budget, made),
        **side_of_mode(made),
    }


def _map(made: ModeBudget) -> dict[str, Any]:
    """Return the torque's amplitude by rate (rows) and order."""
    order_map = made.order_map
    return {"orders": order_map.orders.tolist(), "torque_amplitude_Nm": _rounded_rows(np.abs(order_map.lines))}


def _rounded_rows(values: FloatArray) -> Any:
    """Return a matrix as lists, to six digits, NaN kept."""
    return [[float(f"{v:.6g}") for v in row] for row in values]


def band_edges(highest_hz: float) -> FloatArray:
    """Return the edges of the envelope's bands, third octaves from 1 Hz, Hz."""
    decades = np.log10(highest_hz / LOWEST_BAND_HZ)
    return np.asarray(LOWEST_BAND_HZ * 10.0 ** (np.arange(np.ceil(decades * BANDS_PER_DECADE) + 1) / BANDS_PER_DECADE))


def _envelope(budget: Budget, made: ModeBudget) -> dict[str, Any]:
    """Return the largest torque line over all rates in each non-empty band, with its 95 % interval."""
    edges = band_edges(made.mode.highest_hz)
    rows = []
    bands = torque_bands(made.responses, budget.estimate, budget.file.seed)
    for low, high in pairwise(edges):
        found = [
            (float(abs(line)), response.state.rate, *band[k].tolist())
            for response, band in zip(made.responses, bands, strict=True)
            for k, (f, line) in enumerate(zip(response.state.frequency_hz, response.state.lines, strict=True))
            if low <= f < high
        ]
        if found:
            size, rate, least, most = max(found)
            rows.append(
                {"from_hz": low, "to_hz": high, "torque_amplitude_Nm": size, "ci95_Nm": [least, most], "at_rate": rate}
            )
    return {"bands": rows}


def _emission(made: ModeBudget) -> dict[str, Any]:
    """Return the largest bound of the RMS over all rates in each third octave, with its contributions."""
    rows = []
    for k in range(max((len(exerted.bands_hz) for exerted in made.emissions), default=0)):
        at = int(np.argmax([exerted.band_bound[k] for exerted in made.emissions]))
        exerted = made.emissions[at]
        low, high = exerted.bands_hz[k].tolist()
        if exerted.band_bound[k] > 0.0:
            rows.append(
                {
                    "from_hz": low,
                    "to_hz": high,
                    "at_rate": made.responses[at].state.rate,
                    "modelled_rms_Nm": float(exerted.band_modelled[k]),
                    "residual_rms_Nm": float(exerted.band_residual[k]),
                    "bound_rms_Nm": float(exerted.band_bound[k]),
                }
            )
    return {"bound_share": LEVEL.bound, "bands": rows}


def _over_rate(made: ModeBudget) -> dict[str, Any]:
    two_way = [response.rms().tolist() for response in made.two_way] if made.two_way else None
    return {
        "torque_rms_Nm": [response.state.rms for response in made.responses],
        "rms_rad": [response.rms().tolist() for response in made.responses],
        "rms_ci95_rad": made.rms_band.tolist(),
        "total_rms_rad": [response.total_rms().tolist() for response in made.responses],
        "total_rms_ci95_rad": made.total_band.tolist(),
        "rms_lacking_rad": [response.residual_rms().tolist() for response in made.responses],
        "rms_two_way_rad": two_way,
        "levels_rad": {name: curve.level.tolist() for name, curve in made.levels.items()},
        "levels_ci95_rad": {name: curve.band.tolist() for name, curve in made.levels.items()},
        "decided": {
            "coupling": "two-way" if made.two_way_curves else "one-way",
            "levels_rad": {name: curve.level.tolist() for name, curve in made.deciding.items()},
            "levels_ci95_rad": {name: curve.band.tolist() for name, curve in made.deciding.items()},
        },
    }


def _series(made: ModeBudget) -> dict[str, Any]:
    """Return a section of torque and line of sight at the worst rate: time in s."""
    state = made.responses[made.worst].state
    n = min(round(max(SHOWN_S, 4.0 / state.rate) * state.sample_rate_hz), state.torque.size)
    kept = slice(0, n, max(1, math.ceil(n / SHOWN_SAMPLES)))
    los = line_of_sight_series(made)[kept]
    t = np.arange(state.torque.size)[kept] / state.sample_rate_hz
    return {"time_s": t.tolist(), "torque_Nm": state.torque[kept].tolist(), "line_of_sight_rad": los.T.tolist()}


def _lines(made: ModeBudget) -> dict[str, Any]:
    """Return the lines at the worst rate, and the density of the non-repeating part."""
    at, exerted = made.responses[made.worst], made.emissions[made.worst]
    n = at.state.lines.size
    out: dict[str, Any] = {
        "frequency_hz": at.state.frequency_hz.tolist(),
        "order": at.state.step_orders.tolist(),
        "torque_Nm": np.abs(at.state.lines).tolist(),
        "error_Nm": at.state.error.tolist(),
        "floor_Nm": at.state.floor.tolist(),
        "residual_Nm": exerted.residual[:n].tolist(),
        "bound_Nm": exerted.bound[:n].tolist(),
        "residual_carried": list(exerted.transfer_rules[:n]),
        "lacking": [
            {
                "order": float(q),
                "frequency_hz": float(f),
                "residual_Nm": float(a),
                "bound_Nm": float(b),
                "residual_carried": c,
            }
            for q, f, a, b, c in zip(
                exerted.orders[n:],
                exerted.frequency_hz[n:],
                exerted.residual[n:],
                exerted.bound[n:],
                exerted.transfer_rules[n:],
                strict=True,
            )
        ],
        "samples_a_period": at.state.samples_a_period,
        "line_of_sight_rad": np.abs(at.phasors).T.tolist(),
        "line_of_sight_two_way_rad": np.abs(made.two_way_lines(made.worst)[1]).T.tolist() if made.two_way else None,
        "random": None,
    }
    if at.random is not None:
        frequency, density = at.random.frequency_hz[1:], at.random.density[1:]
        # Neighbouring frequencies are averaged, not skipped: the mean of a density keeps its power.
        each = max(1, math.ceil(frequency.size / SHOWN_SAMPLES))
        whole = frequency.size // each * each
        out["random"] = {
            "frequency_hz": frequency[:whole].reshape(-1, each).mean(axis=1).tolist(),
            "density_rad2_per_hz": density[:whole].reshape(-1, each, density.shape[1]).mean(axis=1).T.tolist(),
            "sampling_error": 1.0 / math.sqrt(each),
        }
    return out


def _cumulative(at: Response) -> dict[str, Any]:
    """Return the RMS of all lines at or below each line, at the worst rate."""
    rms = np.sqrt(np.cumsum(0.5 * np.abs(at.phasors) ** 2, axis=0))
    out: dict[str, Any] = {"frequency_Hz": at.state.frequency_hz.tolist(), "lines": rms.T.tolist()}
    if at.random is not None:
        parts = [cumulative_rms(at.random.frequency_hz, column)[-1] for column in at.random.density.T]
        out["random_total"] = [float(part) for part in parts]
    return out


def _standing_numbers(budget: Budget, s: Standing) -> dict[str, Any]:
    r = s.requirement
    two_way = budget.two_way_by_duty.get(r.name)
    if s.mode != BY_DUTY:
        two_way = next(m.two_way_levels.get(r.name, (0, None))[1] for m in budget.modes if m.mode.name == s.mode)
    both = margins(s, two_way)
    # The rate of the largest level may differ between the couplings.
    both["decided"]["at_rate"] = _rate(budget, s, both["decided"]["coupling"])
    return {
        "requirement": r.name,
        "mode": s.mode,
        "index": r.index.kind,
        "index_words": r.index.row.words,
        "window_s": r.index.window_s,
        "separation_s": r.index.separation_s,
        "axis": r.axis,
        "interpretation": r.interpretation,
        "confidence": r.confidence,
        "worst_member_share": r.worst_member_share,
        "evaluation_period_s": r.evaluation_period_s,
        "limit_rad": r.limit_rad,
        "level_rad": s.level.value,
        "sampling_sigma_rad": s.sampling_rad,
        "nominal_rad": s.nominal_rad,
        "others_rad": s.others_rad,
        "residual_rad": s.residual_rad,
        "residual_share": s.residual_rad / r.limit_rad,
        "sigma_rad": s.level.sigma,
        "ci95_rad": list(s.level.ci95),
        "ecss_summation_rad": s.ecss_rad,
        "two_way_rad": two_way,
        "at_rate": _rate(budget, s, "one-way"),
        "margin": s.margin,
        "margin95": list(s.margin95),
        **both,
        "met": both["decided"]["met"],
        "variance_shares": dict(sorted(s.level.shares.items(), key=lambda item: -abs(item[1]))),
        "spread_shares": dict(sorted(s.spread_shares.items(), key=lambda item: -item[1])),
    }


def _rate(budget: Budget, s: Standing, coupling: str) -> float | None:
    """Return the rate of a mode's largest level, None for a profile and for all modes together."""
    for made in budget.modes:
        if made.mode.name == s.mode and made.responses:
            curves = made.deciding if coupling == "two-way" else made.levels
            return float(made.mode.rates[int(curves[s.requirement.name].level.argmax())])
    return None
