"""Verdicts on requirements at rates that were not measured, from fits whose model lacks an effect.

Each bench of `incomplete` is fitted near its truth as in emission_bound.py. At each held-out rate requirements of every
kind are judged by the prediction; their truth is that of the true mechanism's torque on the base by scipy.signal, and
lies within 6 dB of the mask. SYNTHETIC throughout. Resumable: a finished bench is a file in the folder.

    python benchmarks/emission_with_fit.py --out DIR [--seeds 0:5] [--effects detent stribeck ...]
    python benchmarks/emission_with_fit.py --out DIR --summary
"""

import argparse
import json
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scipy import signal

from emission_bound import HELD_OUT, true_spectrum
from incomplete.benches import make_bench
from incomplete.effects import EFFECTS
from incomplete_benches import seeds_from
from mechid.budgets.attractors import steady_states
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.prediction import TorqueOverRate, predict
from mechid.campaign import load_campaign
from mechid.command import Command, RateProfile
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.identify import identify
from mechid.specification.requirement import KINDS, Mask, Requirement

HIGHEST_HZ = 500.0
LOOKED_AT_S = 6.0
WINDOW_S, FINE_S = 4.0, 1.0
OVER_DB = 6.0
"""How far from the mask a truth lies at most."""
OF_EACH_KIND = 3
"""Requirements of each kind at a rate."""
EDGES_HZ = np.geomspace(4.0, 480.0, 7)
"""Points of the masks, and edges of the bands of RMS and band peaks."""


class Truth:
    """The true torque on the base at a rate: its spectrum and its samples."""

    def __init__(self, effect, seed, stepping, microsteps, rate):
        frequency, spectrum = true_spectrum(effect, seed, stepping, microsteps, rate, LOOKED_AT_S)
        self.frequency_hz, self.amplitude = frequency, np.abs(spectrum)
        # By the spectrum the samples have no aliases; 4 samples in a period of the highest line.
        kept = np.searchsorted(frequency, 4.0 * HIGHEST_HZ)
        self.y = np.fft.irfft(np.append(spectrum[:kept], 0.0)) * kept
        self.fs = 2.0 * kept * (frequency[1] - frequency[0])

    def density(self, window_s):
        """Return frequencies and one-sided density under Hann windows of a length."""
        length = round(window_s * self.fs)
        return signal.welch(self.y, self.fs, "hann", length, length // 2, detrend="constant")

    def of(self, kind):
        """Return frequencies and values of a kind."""
        low, high = EDGES_HZ[0], EDGES_HZ[-1]
        if kind == "amplitude":
            kept = (self.frequency_hz >= low) & (self.frequency_hz <= high)
            return self.frequency_hz[kept], self.amplitude[kept]
        if kind == "psd":
            frequency, density = self.density(FINE_S)
            kept = (frequency >= low) & (frequency <= high)
            return frequency[kept], density[kept]
        bands = self.bands(kind)
        middle = np.sqrt(bands[:, 0] * bands[:, 1])
        if kind == "band_peak":
            return middle, np.array([self.peak(*band) for band in bands])
        frequency, density = self.density(WINDOW_S)
        ends = np.append(frequency, 2 * frequency[-1] - frequency[-2]) - 0.5 * frequency[1]
        total = np.append(0.0, np.cumsum(density)) * frequency[1]
        return middle, np.sqrt(np.diff(np.interp(bands, ends, total), axis=1)[:, 0])

    def bands(self, kind):
        """Return the bands of a kind."""
        if kind != "third_octave":
            return np.column_stack([EDGES_HZ[:-1], EDGES_HZ[1:]])
        centres = 10.0 ** (np.arange(7, 27) / 10.0)
        return np.column_stack([centres / 10.0**0.05, centres * 10.0**0.05])

    def peak(self, low, high):
        """Return the largest magnitude of the band-passed samples; the first second is the filter's own."""
        sections = signal.butter(4, (low, high), "bandpass", fs=self.fs, output="sos")
        return np.abs(signal.sosfilt(sections, self.y - self.y.mean()))[round(self.fs) :].max()


def make_requirement(rng, truth, kind, rate, number):
    """Return a requirement with a random mask, and by how many dB the truth is above it."""
    points = EDGES_HZ if kind != "third_octave" else np.geomspace(5.0, 400.0, 7)
    shape = points ** rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-0.3, 0.3, points.size)
    if kind == "psd":
        shape = shape**2
    over_db = rng.uniform(-OVER_DB, OVER_DB)
    mask = Mask(points, shape, kind in ("rms", "band_peak"))
    frequency, value = truth.of(kind)
    inside = np.isfinite(mask.limit_at(frequency))
    largest = np.max(value[inside] / mask.limit_at(frequency[inside]))
    mask = Mask(points, shape * largest * 10.0 ** (-over_db / (10.0 if kind == "psd" else 20.0)), mask.is_stepwise)
    return Requirement(name=f"{kind} {number}", direction="torque", kind=kind, mask=mask), over_db


def judged(effect, seed, folder):
    """Return the verdicts of a bench at the rates held out, as a plain dict."""
    began = time.process_time()
    bench = make_bench(effect, seed, folder)
    campaign = load_campaign(folder)
    fit = identify(campaign, near=dict(bench.truth), workers=1)
    flying = flying_estimate(fit, Flight())
    fitted_s = time.process_time() - began
    resonance = bench.runs["micro_res"].command["rate"]
    rng = np.random.default_rng((seed, len(effect), 17))
    rows = []
    for stepping, microsteps, share in HELD_OUT:
        rate = round(share * resonance, 2)
        truth = Truth(effect, seed, stepping, microsteps, rate)
        wanted = [make_requirement(rng, truth, kind, rate, k) for kind in KINDS for k in range(OF_EACH_KIND)]
        start = 0.0 if stepping == "micro" else 45.0
        constant = RateProfile.constant(rate)
        command = Command(stepping=stepping, microsteps=microsteps, rate=constant, start_angle_deg=start)
        mode = OperatingMode(name=stepping, command=command, rates=np.array([rate]), highest_hz=HIGHEST_HZ)
        torque = TorqueOverRate(mode=mode, states=steady_states(flying.mechanism, mode, flying.names, 1))
        for (_, over_db), found in zip(
            wanted, predict([one for one, _ in wanted], ("torque",), [torque], flying), strict=True
        ):
            worst = found.judged.worst
            rows.append(
                {
                    "stepping": stepping,
                    "rate": rate,
                    "kind": found.requirement.kind,
                    "over_db": over_db,
                    "verdict": str(found.verdict),
                    "value_over_limit": worst and worst.value / worst.limit,
                    "upper_over_limit": worst and worst.upper / worst.limit,
                    "frequency_hz": worst and worst.frequency_hz,
                }
            )
    took_s = time.process_time() - began
    return {"effect": effect, "seed": seed, "outcome": fit.outcome.code, "cpu_s": [fitted_s, took_s], "rows": rows}


def summed_up(folder):
    """Print false passes and false fails, by kind and by effect."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))]
    print(f"{len(found)} benches, {len({f['effect'] for f in found})} effects, {len(HELD_OUT)} rates held out")
    print("| kind | truth fails | false pass | truth passes | false fail | pass | fail | not shown | not decidable |")
    print("|---|---|---|---|---|---|---|---|---|")
    rows = [row for f in found for row in f["rows"]]
    for kind in KINDS:
        _row(kind, [row for row in rows if row["kind"] == kind])
    _row("all", rows)
    for effect in dict.fromkeys(f["effect"] for f in found):
        _row(effect, [row for f in found if f["effect"] == effect for row in f["rows"]])


def _row(name, rows):
    failing, passing = ([r["verdict"] for r in rows if (r["over_db"] > 0.0) is wanted] for wanted in (True, False))
    counts = Counter(r["verdict"] for r in rows)
    shown = " | ".join(str(counts[word]) for word in ("pass", "fail", "not_shown", "not_decidable"))
    print(f"| {name} | {len(failing)} | {failing.count('pass')} | {len(passing)} | {passing.count('fail')} | {shown} |")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=seeds_from, default=(0, 5), metavar="A:B")
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    parser.add_argument("--summary", action="store_true")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with one_core_algebra():
        for seed in range(*asked.seeds) if not asked.summary else ():
            for effect in asked.effects:
                path = asked.out / f"{effect}_{seed}.json"
                if path.exists():
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    result = judged(effect, seed, Path(folder))
                path.write_text(json.dumps(result), encoding="utf-8")
                print(f"{effect} {seed}: {result['outcome']}, {result['cpu_s'][1]:.1f} s of CPU", flush=True)
    summed_up(asked.out)


if __name__ == "__main__":
    main()
