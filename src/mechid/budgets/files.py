"""Text files of a budget: its tables in CSV, its numbers in budget.json."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from mechid.analysis.residual_emission import TRACKED
from mechid.budgets.budget import Budget
from mechid.budgets.emission import line_sigmas
from mechid.budgets.named_lines import line_names
from mechid.budgets.numbers import band_edges
from mechid.budgets.prediction_table import HEADER, predicted_rows
from mechid.budgets.side_here import COHERENT
from mechid.identification.result.estimate_file import json_text
from mechid.units import unit_words

HARMONICS, LINES, ENVELOPE = "harmonics.csv", "line_of_sight.csv", "envelope.csv"
CROSSINGS, WINDOWED, STATES, JSON = "crossings.csv", "windowed.csv", "steady_states.csv", "budget.json"
EMISSION, COMPONENTS, VERDICTS = "emission.csv", "components.csv", "emission_verdicts.csv"


def budget_texts(budget: Budget, numbers: Mapping[str, Any]) -> dict[str, str | Iterable[str]]:
    """Return the content of each text file by name; `numbers` is the result of `budget_numbers`."""
    texts: dict[str, str | Iterable[str]] = {
        HARMONICS: _harmonics(budget),
        LINES: _line_of_sight(budget),
        ENVELOPE: _envelope(budget),
        EMISSION: _emission(budget),
        CROSSINGS: _crossings(budget),
        JSON: json_text(numbers),
    }
    if numbers["emission_requirements"]:
        texts[VERDICTS] = _emission_verdicts(numbers)
    if any(made.course is not None for made in budget.modes):
        texts[WINDOWED] = _windowed_rms(budget)
    if any(made.states for made in budget.modes):
        texts[STATES] = _steady_states(budget)
    if any(response.side for made in budget.modes for response in made.responses):
        texts[COMPONENTS] = _components(budget)
    return texts


def _harmonics(budget: Budget) -> Iterator[str]:
    """Yield the torque's lines: rate, order, amplitude, phase, sigma, two-way result, numerical error, bound.

    The modelled lines of a rate are followed by unmodelled lines of the bench's records, which have no phase. Phases
    are those of Re(line e^(2 pi i f t)), with t from the start of the motion's period, for one-way and two-way alike.
    """
    yield (
        "mode,rate_steps_per_s,order,frequency_Hz,torque_amplitude_Nm,phase_deg,sigma_Nm,two_way_amplitude_Nm,"
        "two_way_phase_deg,error_Nm,floor_Nm,samples_a_period,residual_Nm,bound_Nm,residual_carried,name\n"
    )
    for made in budget.modes:
        for k, response in enumerate(made.responses):
            s, exerted = response.state, made.emissions[k]
            unmodelled = [
                f"{residual:.6e},{bound:.6e},{how}"
                for residual, bound, how in zip(exerted.residual, exerted.bound, exerted.transfer_rules, strict=True)
            ]
            joined = made.two_way_lines(k)[0] if made.two_way else np.full(s.lines.size, np.nan + 0j)
            sigmas = line_sigmas(budget.estimate, s)
            n, names = s.lines.size, line_names(exerted.orders, budget.estimate.mechanism)
            rows = zip(
                s.step_orders,
                s.frequency_hz,
                s.lines,
                sigmas,
                joined,
                s.error,
                s.floor,
                unmodelled[:n],
                names[:n],
                strict=True,
            )
            for order, f, line, sigma, two_way, error, floor, bound, name in rows:
                phase = "" if np.isnan(two_way) else f"{np.degrees(np.angle(two_way)):.4f}"
                yield (
                    f"{made.mode.name},{s.rate:.9g},{order:.9g},{f:.9g},{abs(line):.9e},"
                    f"{np.degrees(np.angle(line)):.4f},{sigma:.3e},{_number(abs(two_way))},{phase},{error:.3e},{floor:.3e},"
                    f"{s.samples_a_period:.9g},{bound},{name}\n"
                )
            # Unmodelled lines have a residual and a bound only; the columns of the model stay empty.
            rest = zip(exerted.orders[n:], exerted.frequency_hz[n:], unmodelled[n:], names[n:], strict=True)
            for order, f, bound, name in rest:
                yield f"{made.mode.name},{s.rate:.9g},{order:.9g},{f:.9g},{0.0:.9e},,,,,,,,{bound},{name}\n"


def _components(budget: Budget) -> Iterator[str]:
    """Yield the lines of the other components: amplitude, phase relative to the torque's line, sigma, rule.

    They lie along the bench's axes, about the mounting point; lines that noise explains are left out.
    """
    yield "mode,rate_steps_per_s,order,frequency_Hz,component,amplitude,unit,phase_deg,sigma,how\n"
    for made in budget.modes:
        for side, rate in ((r.side, r.state.rate) for r in made.responses if r.side is not None):
            here = side.here
            size, sigma = np.abs(here.lines) + here.bounds, here.sigma
            for k, j in np.argwhere(size > 0.0).tolist():
                order, name, how = TRACKED[k], here.components[j], here.line_use(k, j)
                phase = f"{np.degrees(np.angle(here.lines[k, j])):.2f}" if how == COHERENT else ""
                yield (
                    f"{made.mode.name},{rate:.9g},{order:g},{order * abs(rate):.9g},{name},{size[k, j]:.6e},"
                    f"{unit_words(name)},{phase},{sigma[k, j]:.2e},{how}\n"
                )


def _number(value: float) -> str:
    """Return a number as text, empty for NaN."""
    return "" if np.isnan(value) else f"{value:.9e}"


def _line_of_sight(budget: Budget) -> Iterator[str]:
    """Yield the RMS at each rate with its 95 % interval: modelled lines, two-way, and all sources together."""
    axes = budget.file.structure.line_of_sight
    parts = ("rms", "low95", "high95", "two_way", "total", "total_low95", "total_high95")
    yield "mode,rate_steps_per_s," + ",".join(f"{part}_{axis}_rad" for part in parts for axis in axes) + "\n"
    for made in budget.modes:
        for k, response in enumerate(made.responses):
            joined = made.two_way[k].rms() if made.two_way else np.full(len(axes), np.nan)
            (low, high), (least, most) = made.rms_band[k].T, made.total_band[k].T
            every = (*response.rms(), *low, *high, *joined, *response.total_rms(), *least, *most)
            numbers = ",".join(_number(v) for v in every)
            yield f"{made.mode.name},{response.state.rate:.9g},{numbers}\n"


def _steady_states(budget: Budget) -> Iterator[str]:
    """Yield every steady state: how it was reached, its periods, its slowest transient, its RMS."""
    axes = ",".join(f"rms_{axis}_rad" for axis in budget.file.structure.line_of_sight)
    columns = "reached,periods,largest_multiplier,decay_s,follows,worst,torque_rms_Nm"
    yield f"mode,rate_steps_per_s,{columns},{axes},steps_a_period,torque_rms_error_Nm\n"
    for made in budget.modes:
        for worst, here in zip(made.responses, made.states, strict=True):
            for response in here:
                s = response.state
                yield (
                    f"{made.mode.name},{s.rate:.9g},{' and '.join(s.reached)},{s.periods},"
                    f"{_number(s.largest_multiplier)},{_number(s.decay_s)},{int(s.follows)},{int(response is worst)},"
                    f"{s.rms:.9e},{','.join(_number(v) for v in response.whole_rms())},{s.steps},{s.rms_error:.3e}\n"
                )


def _windowed_rms(budget: Budget) -> Iterator[str]:
    axes = budget.file.structure.line_of_sight
    yield "mode,time_s,torque_rms_Nm," + ",".join(f"rms_{axis}_rad" for axis in axes) + "\n"
    for made in budget.modes:
        if made.course is not None:
            rows = zip(
                made.course.window_times_s, made.course.windowed_torque_rms(), made.course.windowed_rms(), strict=True
            )
            for time, torque, rms in rows:
                yield f"{made.mode.name},{time:.9g},{torque:.9e}," + ",".join(f"{v:.9e}" for v in rms) + "\n"


def _envelope(budget: Budget) -> Iterator[str]:
    """Yield the largest torque line of each band over all rates, by mode."""
    yield "mode,from_Hz,to_Hz,torque_amplitude_Nm\n"
    for made in budget.modes:
        if made.responses:
            edges = band_edges(made.mode.highest_hz)
            for low, high, size in zip(edges, edges[1:], made.order_map.envelope(edges), strict=False):
                yield f"{made.mode.name},{low:.6g},{high:.6g},{size:.9e}\n"


def _emission(budget: Budget) -> Iterator[str]:
    """Yield the torque's RMS in third octaves at each rate: modelled, unmodelled, and the bound of both."""
    yield "mode,rate_steps_per_s,from_Hz,to_Hz,modelled_rms_Nm,residual_rms_Nm,bound_rms_Nm\n"
    for made in budget.modes:
        for response, exerted in zip(made.responses, made.emissions, strict=True):
            columns = (exerted.band_modelled, exerted.band_residual, exerted.band_bound)
            for (low, high), *rms in zip(exerted.bands_hz, *columns, strict=True):
                numbers = ",".join(f"{value:.6e}" for value in rms)
                yield f"{made.mode.name},{response.state.rate:.9g},{low:.6g},{high:.6g},{numbers}\n"


def _emission_verdicts(numbers: Mapping[str, Any]) -> Iterator[str]:
    """Yield the verdict on each emission requirement at each rate of each mode."""
    yield ",".join("mode" if name == "stepping" else name for name in HEADER) + "\n"
    for one in numbers["emission_requirements"]:
        for row in predicted_rows(one, one):
            yield ",".join(_cell(cell) for cell in row) + "\n"


def _cell(value: Any) -> str:
    """Return a cell of a CSV file: a name with its commas quoted, a number with ten digits."""
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if set(value) & set(',"\n') else value
    return "" if value is None else f"{value:.10g}"


def _crossings(budget: Budget) -> Iterator[str]:
    yield "rate_steps_per_s,order,mode,frequency_Hz\n"
    for c in budget.crossings:
        yield f"{c.rate:.9g},{c.order:g},{c.mode},{c.frequency_hz:.9g}\n"
