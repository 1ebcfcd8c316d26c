"""How far the errors of forces and moments beside the torque can be trusted, on SYNTHETIC records of known lines.

    PYTHONPATH=tests:tests/analysis:tests/budgets python benchmarks/six_components.py

1. Scatter of amplitude and phase over draws of the noise, in standard errors as stated: 1 is right.
2. Lines heard in noise alone, in records without any: one of a hundred rates is meant to have one.
3. Phases known of lines that have none, each window's drawn: one of a hundred is meant to be.
4. How often the 95 % interval of the line of sight's RMS holds the truth, by what noise is to the lines.
"""

from __future__ import annotations

import numpy as np
from numpy.random import default_rng
from test_side_components import DRIVE, EXERTED, RATE
from test_side_source import response, source_of

from mechid.analysis.residual_emission import TRACKED
from mechid.analysis.side_components import side_lines
from table_of_six import MEASURED, measured, tracked

DRAWS = 200


def scatter(noise: float) -> tuple[float, float, int]:
    """Return the root mean square of amplitude and phase errors in standard errors, and their number."""
    off = []
    for seed in range(DRAWS):
        (at,) = tracked(measured(EXERTED, RATE, default_rng(seed), noise=noise), RATE)
        found = side_lines(at)
        for j, component in enumerate(MEASURED):
            for order, true in EXERTED.get(component, {}).items():
                k = TRACKED.index(order)
                if found.known[k, j]:
                    turned = np.angle(np.exp(1j * found.phase[k, j]) * DRIVE[order] / true)
                    off.append(
                        ((found.amplitude[k, j] - abs(true)) / found.sigma[k, j], turned / found.phase_sigma[k, j])
                    )
    return (*np.sqrt(np.mean(np.square(off), axis=0)).tolist(), len(off))


def heard_in_noise() -> int:
    """Return how many of the rates have a line where there is none."""
    records = (measured({"moment_z": DRIVE}, RATE, default_rng(seed), seconds=2.0) for seed in range(DRAWS))
    return sum(bool(side_lines(at).heard.any()) for record in records for at in tracked(record, RATE))


def phases_of_none(windows: int) -> float:
    """Return the share of lines of which each window has a phase of its own that are taken as having one."""
    taken, k = 0, TRACKED.index(1.0)
    for seed in range(DRAWS):
        rng = default_rng(seed)
        record = measured(EXERTED, RATE, rng, seconds=0.4 * windows + 0.01)
        steps = RATE * np.arange(record.samples) / record.sample_rate_hz
        own = rng.uniform(0.0, 2.0 * np.pi, windows)[np.minimum((steps / steps[-1] * windows).astype(int), windows - 1)]
        record.channel("force_z").data[:] += 0.3 * np.cos(2.0 * np.pi * steps + own)
        (at,) = tracked(record, RATE)
        taken += bool(side_lines(at).known[k, MEASURED.index("force_z")])
    return taken / DRAWS


def coverage(noise: float) -> float:
    """Return how often the 95 % interval of the RMS along either line of sight holds the truth."""
    truth, inside = response(source_of(), 10.0).rms(), []
    for seed in range(DRAWS // 4):
        found = response(source_of(seed=seed, noise=noise, rates=(10.0,), seconds=8.0), 10.0)
        drive = np.broadcast_to(found.drive, (400, *found.drive.shape))
        draws = found.side.drawn(drive, np.zeros((400, len(found.drive))), default_rng(0))
        low, high = np.quantile(np.sqrt(0.5 * np.sum(np.abs(draws) ** 2, axis=1)), (0.025, 0.975), axis=0)
        inside += ((low <= truth) & (truth <= high)).tolist()
    return float(np.mean(inside))


if __name__ == "__main__":
    for level in (1e-3, 0.03):
        print("scatter, noise {:g}: amplitude {:.2f}, phase {:.2f} of {}".format(level, *scatter(level)))
    print(f"rates with a line in noise alone: {heard_in_noise()} of {DRAWS}")
    for count in (2, 3, 5, 10):
        print(f"phase of none taken as one, {count} windows: {100.0 * phases_of_none(count):.1f} %")
    for level in (0.01, 0.05, 0.1):
        print(f"coverage, noise {level:g}: {100.0 * coverage(level):.0f} %")
