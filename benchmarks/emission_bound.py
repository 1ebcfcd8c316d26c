"""Does the emission's 95 % bound hold at rates that were not measured, where the model lacks an effect?

Each bench of `incomplete` is fitted near its truth, its estimate goes through the budget at rates that no constant-rate
record has, and lines and third octaves of the torque on the base are compared with those of the true mechanism, without
its housing and its instruments, by the simulator that made the records. SYNTHETIC throughout. Resumable: a finished
bench is a file in the folder.

    python benchmarks/emission_bound.py --out DIR [--seeds 5] [--effects detent stribeck ...]
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np

from incomplete.benches import drawn, make_bench
from incomplete.effects import EFFECTS
from incomplete.recording import Run, recorded
from mechid.analysis import validate
from mechid.budgets.emission import emission
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.residual_source import EDGES_HZ
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.campaign import load_campaign
from mechid.command import Command, RateProfile
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.identify import identify
from mechid.identification.result.fit_file import read_fit
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results
from mechid.structure import Modes, Structure

HELD_OUT = (
    ("full", 1, 0.35),
    ("full", 1, 0.75),
    ("micro", 16, 0.4),
    ("micro", 16, 0.8),
    ("micro", 16, 1.3),
    ("micro", 16, 2.0),
)
"""Stepping, microsteps, and rate over the bench's rate at the resonance: full steps were recorded at 0.5 and 1 of it
and at 5 a second, microsteps at 1 of it and through a sweep to 2.4."""
SETTLED_S, LOOKED_AT_S, HIGHEST_HZ = 1.5, 2.0, 500.0
SAMPLE_RATE_HZ = 60_000.0
"""Of the truth, about: a whole number of samples a step, so that its lines stand in bins."""
HOUSING = 2.0 * np.pi * 4000.0, 0.7
"""Frequency in rad/s and damping of the housing that the rotor's reaction passes; it is divided out of the lines."""
LEAST = 0.01
"""Of the largest true line at a rate: smaller ones, and bands below it, are not compared."""


def truth_of(effect, seed, stepping, microsteps, rate):
    """Return amplitudes of the true torque on the base at multiples of a quarter of the rate, and its third octaves."""
    frequency, spectrum = true_spectrum(effect, seed, stepping, microsteps, rate, LOOKED_AT_S)
    kept = frequency <= 2.0 * HIGHEST_HZ
    frequency, amplitude = frequency[kept], np.abs(spectrum[kept])
    each = round(rate / frequency[1]) // 4
    power = np.histogram(frequency[1:], EDGES_HZ, weights=0.5 * amplitude[1:] ** 2)[0]
    lines = amplitude[each::each][: int(4.0 * HIGHEST_HZ / rate)]
    orders = np.arange(1, lines.size + 1) / 4.0
    return dict(zip(orders.tolist(), lines.tolist(), strict=True)), np.sqrt(power)


def true_spectrum(effect, seed, stepping, microsteps, rate, seconds, table=None):
    """Return frequencies and complex amplitudes of the true torque on the base over about so many seconds."""
    mechanism, size = drawn(effect, seed)
    if not EFFECTS[effect].in_mechanism:
        size = {}
    command = {"stepping": stepping, "rate": rate}
    command |= {"microsteps": microsteps} if stepping == "micro" else {"start_angle_deg": 45.0}
    command |= {"table": table} if table is not None else {}
    a_step = round(SAMPLE_RATE_HZ / rate)
    settled, steps = (4 * int(np.ceil(length * rate / 4.0)) for length in (SETTLED_S, seconds))
    run = Run(command, (settled + steps) / rate)

    def bins(gain):
        seen = mechanism.with_values({"housing.gain": gain, "housing.frequency": w, "housing.damping": zeta})
        torque = recorded(seen, size, run, None, a_step * rate).torque_Nm[settled * a_step : (settled + steps) * a_step]
        return 2.0 / torque.size * np.fft.rfft(torque)

    w, zeta = HOUSING
    load = bins(0.0)
    frequency = np.arange(load.size) * rate / steps
    s = 2j * np.pi * frequency / w
    return frequency, load + (bins(1.0) - load) * (s**2 + 2.0 * zeta * s + 1.0)


def estimated(effect, seed, folder):
    """Make a bench, fit it near its truth, leave the results in a folder, and return the bench and the estimate."""
    bench = make_bench(effect, seed, folder)
    campaign = load_campaign(folder)
    fit = identify(campaign, near=dict(bench.truth), workers=1)
    validation = validate(campaign, fit)
    write_results(fit, report_data(fit, validation=validation), folder / "fit", validation=validation)
    return bench, fit


def compared(effect, seed, folder):
    """Return what a bench's bound and truth are at the rates held out, as a plain dict."""
    began = time.time()
    bench, fit = estimated(effect, seed, folder)
    fitted_s = time.time() - began
    flying = flying_estimate(read_fit(folder / "fit" / "estimate.json"), Flight())
    resonance = bench.runs["micro_res"].command["rate"]
    rows = [row for at in HELD_OUT for row in _at_rate(effect, seed, flying, *at[:2], round(at[2] * resonance, 2))]
    return {
        "effect": effect,
        "seed": seed,
        "outcome": fit.outcome.code,
        "fitted_s": fitted_s,
        "all_s": time.time() - began,
        "rows": rows,
    }


def _at_rate(effect, seed, flying, stepping, microsteps, rate):
    lines, bands = truth_of(effect, seed, stepping, microsteps, rate)
    start = 0.0 if stepping == "micro" else 45.0
    command = Command(stepping=stepping, microsteps=microsteps, rate=RateProfile.constant(rate), start_angle_deg=start)
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]), highest_hz=HIGHEST_HZ)
    substeps = enough_substeps(flying.mechanism, mode, flying.names)
    state = steady_state(flying.mechanism, mode, rate, flying.names, substeps)
    here = flying.residual.at(command, rate)
    found = emission(respond(state, NO_STRUCTURE, here, HIGHEST_HZ), flying, HIGHEST_HZ, 0)
    about = {"stepping": stepping, "rate": rate}
    for k, order in enumerate(found.orders.tolist()):
        if order in lines:
            yield {
                **about,
                "kind": "line",
                "at": order,
                "hz": order * rate,
                "truth": lines[order],
                "modelled": abs(found.modelled[k]),
                "residual": found.residual[k],
                "bound": found.bound[k],
                "largest": max(lines.values()),
            }
    for k, (low, high) in enumerate(found.bands_hz.tolist()):
        if high <= HIGHEST_HZ:
            yield {
                **about,
                "kind": "band",
                "at": low,
                "hz": low,
                "truth": bands[k],
                "modelled": found.band_modelled[k],
                "residual": found.band_residual[k],
                "bound": found.band_bound[k],
                "largest": max(lines.values()) / np.sqrt(2.0),
            }


NO_STRUCTURE = Structure(
    name="none", model=Modes(np.array([1.0]), np.array([0.1]), np.array([0.0]), np.array([[0.0]])), line_of_sight=("x",)
)


def summed_up(folder):
    """Print coverage and the median of bound over truth, of all benches in a folder and effect by effect."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))]
    print(f"{len(found)} benches, {sum(f['fitted_s'] for f in found) / len(found):.1f} s a fit")
    for kind in ("line", "band"):
        _line(f"all {kind}s", [row for f in found for row in f["rows"] if row["kind"] == kind])
    for effect in dict.fromkeys(f["effect"] for f in found):
        for kind in ("line", "band"):
            rows = [row for f in found if f["effect"] == effect for row in f["rows"] if row["kind"] == kind]
            _line(f"{effect} {kind}s", rows)


def _line(name, rows):
    rows = [row for row in rows if row["truth"] >= LEAST * row["largest"]]
    ratio = np.array([row["bound"] / row["truth"] for row in rows])
    plain = np.array([row["modelled"] / row["truth"] for row in rows])
    print(
        f"{name:32} {ratio.size:6d} under the bound {100 * np.mean(ratio >= 1):5.1f} %, bound over truth "
        f"{np.median(ratio):6.2f} (90 %: {np.quantile(ratio, 0.9):6.2f}), model over truth {np.median(plain):5.2f}"
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with one_core_algebra():
        for seed in range(asked.seeds):
            for effect in asked.effects:
                path = asked.out / f"{effect}_{seed}.json"
                if path.exists():
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    result = compared(effect, seed, Path(folder))
                path.write_text(json.dumps(result), encoding="utf-8")
                print(f"{effect} {seed}: {result['outcome']}, {result['all_s']:.1f} s", flush=True)
    summed_up(asked.out)


if __name__ == "__main__":
    main()
