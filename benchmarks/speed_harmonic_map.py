"""A speed-harmonic map with its bands: 240 rates in two stepping modes, 200 parameter samples at each.

Measured: the steady states with their exact derivatives to all estimated parameters, from rest and from those of the
neighbouring rates, and the samples moved along them; beside it those from rest alone. At some rates of each mode as
many parameter sets are simulated anew, which gives what the whole map would take that way, and how far the 95 % limits
of the lines' amplitudes differ.

    python benchmarks/speed_harmonic_map.py ESTIMATE.json [--workers 2] [--anew 3] [--out FILE]
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np

from bench_sweep import RESULTS, machine
from mechid.budgets.attractors import steady_states
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.line_of_sight import Response
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.over_rate import torque_bands
from mechid.budgets.settings import LEVEL
from mechid.budgets.shares import deviations
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.identification.computation.parallel import map_tasks, one_core_algebra
from mechid.identification.result.fit_file import read_fit

RATES = np.linspace(10.0, 120.0, 240)
COMPARED = 0.05
"""Lines above this share of the largest at their rate are compared."""


def modes():
    any_rate = RateProfile.constant(46.0)
    for name, stepping, n in (("full", "full", 1), ("micro", "micro", 16)):
        command = Command(stepping=stepping, microsteps=n, rate=any_rate, start_angle_deg=45.0 if n == 1 else 0.0)
        yield OperatingMode(name=name, command=command, rates=RATES)


def as_response(state):
    unit = np.ones((state.lines.size, 1), dtype=np.complex128)
    return Response(("torque",), state, unit, state.lines[:, None], 0.0, None)


def measured(estimate, mode, workers):
    """Return the responses at all rates, their bands, all steady states, and times in s: from rest, all, samples."""
    substeps = enough_substeps(estimate.mechanism, mode, estimate.names)
    one = partial(_at, estimate.mechanism, mode, estimate.names, substeps)
    one(46.0)  # the kernel is compiled or loaded before the clock runs
    clock = [time.perf_counter()]
    map_tasks(one, [float(rate) for rate in RATES], workers)
    clock.append(time.perf_counter())
    found = steady_states(estimate.mechanism, mode, estimate.names, workers)
    clock.append(time.perf_counter())
    responses = [as_response(max(here, key=lambda state: state.rms)) for here in found]
    bands = torque_bands(responses, estimate, seed=0)
    clock.append(time.perf_counter())
    return responses, bands, found, np.diff(clock)


def _at(mechanism, mode, names, substeps, rate):
    return steady_state(mechanism, mode, rate, names, substeps)


def simulated_anew(estimate, mode, responses, bands, count, workers):
    """Return what a run takes in s, and the largest difference of a limit in widths of its interval."""
    substeps, off = enough_substeps(estimate.mechanism, mode), 0.0
    by = deviations(estimate.covariance, LEVEL.samples, np.random.default_rng(0))  # the samples of the bands
    nominal = np.array([estimate.mechanism.value(name) for name in estimate.names])
    start = time.perf_counter()
    chosen = np.linspace(0, RATES.size - 1, count + 2).round().astype(int)[1:-1]
    for k in chosen:
        sets = [estimate.mechanism.with_values(dict(zip(estimate.names, nominal + row, strict=True))) for row in by]
        run = partial(_moved, mode, substeps, float(RATES[k]))
        size = np.abs(np.array(map_tasks(run, sets, workers)))
        limits = np.quantile(size, LEVEL.limits95, axis=0).T
        large = np.abs(responses[k].state.lines) > COMPARED * np.abs(responses[k].state.lines).max()
        width = np.ptp(limits, axis=1)
        off = max(off, float((np.abs(limits - bands[k]) / width[:, None])[large].max()))
    return (time.perf_counter() - start) / (chosen.size * LEVEL.samples), off


def _moved(mode, substeps, rate, mechanism):
    return steady_state(mechanism, mode, rate, (), substeps).lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("estimate", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--anew", type=int, default=3)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    estimate = replace(
        flying_estimate(read_fit(arguments.estimate), Flight()), discrepancy=Discrepancy()
    )  # parameters alone
    rows = {}
    with one_core_algebra():
        for mode in modes():
            responses, bands, found, (from_rest_s, states_s, samples_s) = measured(estimate, mode, arguments.workers)
            run_s, off = simulated_anew(estimate, mode, responses, bands, arguments.anew, arguments.workers)
            rows[mode.name] = {
                "steady_states_s": states_s,
                "of_these_from_rest_s": from_rest_s,
                "samples_s": samples_s,
                "rates_with_several": sum(len(here) > 1 for here in found),
                "rates_of_several_periods": sum(any(s.periods != 1 for s in here) for here in found),
                "longest_decay_s": max(state.decay_s for here in found for state in here),
                "total_s": states_s + samples_s,
                "simulated_anew_would_take_s": run_s * RATES.size * LEVEL.samples,
                "largest_difference_of_limits": off,
            }
    result = {
        "rates": int(RATES.size),
        "samples": LEVEL.samples,
        "parameters": len(estimate.names),
        "workers": arguments.workers,
        "machine": machine(),
        "modes": rows,
        "total_s": sum(row["total_s"] for row in rows.values()),
    }
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%S")
    out = arguments.out or RESULTS / f"speed-harmonic-map-{stamp}.json"
    out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
