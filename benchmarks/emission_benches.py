"""Verdicts of `mechid emission` on synthetic six-component benches, beside the truth of the noise-free load.

    python benchmarks/emission_benches.py [BENCHES] [FIRST]

Each bench has 4 to 12 rates, a background as published for a real one, mains, and six requirements whose truth lies
within 6 dB of the mask. Printed: false passes and false fails, the verdicts, errors of line amplitudes.
"""

import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import mechid
from emission.bench import DIRECTIONS, make_bench, write_bench
from emission.truth import KINDS, make_requirement
from mechid.emissions.spectra import window_length

SURE, COUNTED = 100.0, 10.0
"""Amplitude of a line over its standard error from which 3 % are to be held, and from which its error is counted."""


def judge_bench(seed, folder, **options):
    """Return (kind, dB above the mask, verdict) of each requirement, and the relative errors of the lines."""
    bench = make_bench(seed, **options)
    campaign = write_bench(bench, folder)
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
    return verdicts, line_errors(bench, found, bench.sample_rate_hz / length)


def line_errors(bench, found, bin_hz):
    """Return the relative errors of the amplitudes of lines that stand clearly above the noise, with their errors."""
    errors = []
    for k, run in enumerate(bench.runs):
        for d, direction in enumerate(DIRECTIONS):
            own = [one for one in found.lines if one.record == f"run_{k}" and one.direction == direction]
            seen = np.array([one.frequency_hz for one in own])
            for frequency, amplitude in zip(*run.lines[d], strict=True):
                near_mains = abs(frequency / 50.0 - round(frequency / 50.0)) * 50.0 < 4.0 * bin_hz and frequency < 250.0
                if near_mains or not seen.size:
                    continue
                line = own[int(np.argmin(np.abs(seen - frequency)))]
                if abs(line.frequency_hz - frequency) < 0.5 * bin_hz and amplitude > COUNTED * line.sigma:
                    errors.append((line.amplitude / amplitude - 1.0, line.sigma / amplitude))
    return errors


def main():
    count, first = (
        (int(word) for word in (*sys.argv[1:], "200", "0")[:2]) if len(sys.argv) != 2 else (int(sys.argv[1]), 0)
    )
    verdicts, errors = [], []
    for seed in range(first, first + count):
        with tempfile.TemporaryDirectory() as folder:
            found, off = judge_bench(seed, Path(folder))
        verdicts += found
        errors += off
    report(verdicts, np.array(errors))


def report(verdicts, errors):
    """Print the shares of each kind."""
    print(f"{'kind':14}{'truth fails':>12}{'false pass':>11}{'truth passes':>13}{'false fail':>11}  verdicts")
    for kind in (*KINDS, "all"):
        own = [(over, verdict) for name, over, verdict in verdicts if kind in (name, "all")]
        failing, passing = ([v for over, v in own if (over > 0.0) is wanted] for wanted in (True, False))
        counts = ", ".join(f"{v} {n}" for v, n in sorted(Counter(v for _, v in own).items()))
        shares = f"{len(failing):12d}{failing.count('pass'):11d}{len(passing):13d}{passing.count('fail'):11d}"
        print(f"{kind:14}{shares}  {counts}")
    off, sigma = errors.T
    print(
        f"line amplitudes: {off.size} lines above {COUNTED:g} sigma, mean error {100 * off.mean():+.2f} %, "
        f"within 1.96 sigma {100 * np.mean(np.abs(off) <= 1.96 * sigma):.1f} %"
    )
    sure = np.abs(off[sigma * SURE <= 1.0])
    print(
        f"{sure.size} lines above {SURE:g} sigma: median {100 * np.median(sure):.2f} %, 95 % within "
        f"{100 * np.quantile(sure, 0.95):.2f} %, within 3 %: {100 * np.mean(sure <= 0.03):.2f} %"
    )


if __name__ == "__main__":
    main()
