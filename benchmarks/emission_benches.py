"""Verdicts of `mechid emission` on synthetic six-component benches, beside the truth of the noise-free load.

    python benchmarks/emission_benches.py [BENCHES] [FIRST] [--table] [--uncorrected] [--peaks]

Each bench has 4 to 12 rates, a background as published for a real one, mains, and six requirements whose truth lies
within 6 dB of the mask. With a table, its modes at 900 to 1400 Hz and 3 % of cross-talk are in the records, and the
campaign declares what a laboratory knows of them; uncorrected, it declares nothing. Printed: false passes and false
fails, the verdicts, errors of line amplitudes. With peaks: those of bands in records almost free of noise.
"""

import argparse
import tempfile
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfilt, welch

import mechid
from emission.bench import DIRECTIONS, make_bench, write_bench
from emission.table import know_table
from emission.truth import KINDS, RANGE_HZ, make_requirement
from mechid.emissions.band_peak import band_peaks
from mechid.emissions.declared import load_declared
from mechid.emissions.spectra import window_length

SURE, COUNTED = 100.0, 10.0
"""Amplitude of a line over its standard error from which 3 % are to be held, and from which its error is counted."""
JUDGED = 0.7
"""Frequency over that of the table's first mode up to which line amplitudes are compared."""
QUIET = 1e-4


def declare(bench, seed, folder, *, corrected=True, exact=False):
    """Write the campaign of a bench with what is known of its table, and return its path."""
    if bench.table is None or not corrected:
        return write_bench(bench, folder)
    return write_bench(bench, folder, **know_table(bench.table, np.random.default_rng(seed), seed % 3, folder, exact))


def judge_bench(seed, folder, *, table=False, corrected=True):
    """Return (kind, dB above the mask, verdict) of each requirement, and the errors of the lines."""
    bench = make_bench(seed, table=table)
    campaign = declare(bench, seed, folder, corrected=corrected)
    rng = np.random.default_rng(seed + 10_000)
    length = window_length(bench.background.shape[1], bench.sample_rate_hz)
    made, truths = [], {}
    for k, direction in enumerate(DIRECTIONS):
        kind = KINDS[(seed + k) % len(KINDS)]
        text, over_db = make_requirement(rng, f"{direction} {kind}", direction, kind, bench, length)
        made.append(text)
        truths[f"{direction} {kind}"] = (kind, over_db)
    (folder / "specification.toml").write_text("\n".join(made))
    found = mechid.emission(campaign, requirements=folder / "specification.toml")
    verdicts = [(*truths[one.requirement.name], str(one.verdict)) for one in found.assessments]
    return verdicts, line_errors(bench, found, bench.sample_rate_hz / length), found.usable_hz[1]


def line_errors(bench, found, bin_hz):
    """Return relative error, stated standard error, that of the noise alone, and frequency over the table's first mode.

    Of lines clearly above the noise. The noise beside a line is that of the background, by scipy.signal.
    """
    errors = []
    length = round(bench.sample_rate_hz / bin_hz)
    f, density = welch(bench.background, bench.sample_rate_hz, "hann", length)
    windows = bench.background.shape[1] // length
    first = bench.table.frequency_hz.min() if bench.table else np.inf
    for k, run in enumerate(bench.runs):
        for d, direction in enumerate(DIRECTIONS):
            own = [one for one in found.lines if one.record == f"run_{k}" and one.direction == direction]
            seen = np.array([one.frequency_hz for one in own])
            for frequency, amplitude in zip(*run.lines[d], strict=True):
                near_mains = abs(frequency / 50.0 - round(frequency / 50.0)) * 50.0 < 4.0 * bin_hz and frequency < 250.0
                if near_mains or not seen.size or frequency > JUDGED * first:
                    continue
                line = own[int(np.argmin(np.abs(seen - frequency)))]
                near = density[d, np.abs(f - frequency) < 8.0 * bin_hz].mean()
                noise = np.sqrt(1.5 * bin_hz * near / windows)
                if abs(line.frequency_hz - frequency) < 0.5 * bin_hz and amplitude > COUNTED * noise:
                    off = line.amplitude / amplitude - 1.0
                    errors.append((off, line.sigma / amplitude, noise / amplitude, frequency / first))
    return errors


def peak_errors(seed, folder, exact):
    """Return the relative errors of the peaks of bands of corrected records, against filtered noise-free loads."""
    bench = make_bench(seed, table=True, noise=QUIET)
    campaign = declare(bench, seed, folder, exact=exact)
    (folder / "none.toml").write_text(
        '[[requirement]]\nname = "any"\ndirection = "fx"\nkind = "rms"\nunit = "N"\nmask = [[20.0, 1.0], [90.0, 1.0]]\n'
    )
    edges = np.geomspace(*RANGE_HZ, 5)
    bands, errors = list(pairwise(edges)), []
    for run, record in zip(bench.runs, load_declared(campaign, folder / "none.toml").read(), strict=True):
        fs = record.data.sample_rate_hz
        for load, channel in zip(run.load, record.data.channels, strict=True):
            made = [sosfilt(butter(4, b, "bandpass", fs=fs, output="sos"), load - load.mean()) for b in bands]
            errors += (band_peaks(channel.data[:], fs, bands)[0] / np.abs(made).max(axis=1) - 1.0).tolist()
    return errors


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("benches", nargs="?", type=int, default=200)
    parser.add_argument("first", nargs="?", type=int, default=0)
    for name in ("table", "uncorrected", "peaks"):
        parser.add_argument(f"--{name}", action="store_true")
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.benches)
    if asked.peaks:
        for exact in (True, False):
            off = np.abs([e for seed in seeds for e in in_folder(peak_errors, seed, exact)])
            known = "exactly" if exact else "as a laboratory knows it"
            print(f"table known {known}: {off.size} band peaks, {shares(off, 0.01)}")
        return
    verdicts, errors, usable = [], [], []
    for seed in seeds:
        judged = in_folder(judge_bench, seed, table=asked.table or asked.uncorrected, corrected=not asked.uncorrected)
        verdicts += judged[0]
        errors += judged[1]
        usable.append(judged[2])
    report(verdicts, np.array(errors))
    print(f"usable up to {np.min(usable):.0f} to {np.max(usable):.0f} Hz, median {np.median(usable):.0f} Hz")


def in_folder(work, seed, *more, **options):
    """Return what a function of a seed and a folder makes, in a folder that is removed."""
    with tempfile.TemporaryDirectory() as folder:
        return work(seed, Path(folder), *more, **options)


def shares(off, wanted):
    """Return the quantiles of errors, and the share of those within what is wanted, in words."""
    within = ", ".join(f"{100 * q:g} % within {100 * np.quantile(off, q):.2f} %" for q in (0.95, 1.0))
    share = 100 * np.mean(off <= wanted)
    return f"median {100 * np.median(off):.2f} %, {within}; within {100 * wanted:g} %: {share:.2f} %"


def report(verdicts, errors):
    """Print the shares of each kind."""
    print(f"{'kind':14}{'truth fails':>12}{'false pass':>11}{'truth passes':>13}{'false fail':>11}  verdicts")
    for kind in (*KINDS, "all"):
        own = [(over, verdict) for name, over, verdict in verdicts if kind in (name, "all")]
        failing, passing = ([v for over, v in own if (over > 0.0) is wanted] for wanted in (True, False))
        counts = ", ".join(f"{v} {n}" for v, n in sorted(Counter(v for _, v in own).items()))
        found = f"{len(failing):12d}{failing.count('pass'):11d}{len(passing):13d}{passing.count('fail'):11d}"
        print(f"{kind:14}{found}  {counts}")
    off, sigma, noise, place = errors.T
    print(
        f"{off.size} lines above {COUNTED:g} sigma of the noise: mean error {100 * off.mean():+.2f} %, "
        f"within 1.96 sigma {100 * np.mean(np.abs(off) <= 1.96 * sigma):.1f} %"
    )
    for low, high in ((0.0, JUDGED), (0.5 * JUDGED, JUDGED)):
        sure = np.abs(off[(noise * SURE <= 1.0) & (place >= low) & (place <= high)])
        if sure.size:
            where = f" at {low:.2g} to {high:.2g} of the first table mode" if np.any(place > 0.0) else ""
            print(f"{sure.size} lines above {SURE:g} sigma of the noise{where}: {shares(sure, 0.03)}")


if __name__ == "__main__":
    main()
