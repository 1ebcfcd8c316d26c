"""The truth of a requirement, from the noise-free load by scipy.signal alone."""

import numpy as np
from scipy.signal import butter, sosfilt, welch

KINDS = ("amplitude", "psd", "rms", "third_octave", "band_peak")
RANGE_HZ = (12.0, 600.0)
"""Of the masks."""


def make_requirement(rng, name, direction, kind, bench, length):
    """Return the table of a requirement as text, and by how much the truth exceeds its mask, dB; above 0 it fails."""
    points = np.sort(np.exp(rng.uniform(*np.log(RANGE_HZ), 4)))
    points[0], points[-1] = RANGE_HZ
    limits = 10.0 ** rng.uniform(-0.5, 0.5, 4)
    index = ("fx", "fy", "fz", "mx", "my", "mz").index(direction)
    decibels = 10.0 if kind == "psd" else 20.0
    ratio = largest_ratio(kind, index, bench, (points, limits), length)
    over_db = rng.uniform(-6.0, 6.0)
    limits = limits * ratio / 10.0 ** (over_db / decibels)
    mask = ", ".join(f"[{f!r}, {limit!r}]" for f, limit in zip(points.tolist(), limits.tolist(), strict=True))
    unit = ("N" if index < 3 else "N*m") if kind != "psd" else ("N^2/Hz" if index < 3 else "N^2*m^2/Hz")
    text = f'[[requirement]]\nname = "{name}"\ndirection = "{direction}"\nkind = "{kind}"\n'
    return f'{text}unit = "{unit}"\nmask = [{mask}]\n', over_db


def limit_at(frequency, mask):
    return np.exp(np.interp(np.log(frequency), *np.log(mask)))


def largest_ratio(kind, index, bench, mask, length):
    """Return the largest value over its limit in all runs."""
    return max(_largest(kind, run, index, bench.sample_rate_hz, (mask, length)) for run in bench.runs)


def _largest(kind, run, index, fs, how):
    mask, length = how
    points, limits = mask
    y = run.load[index]
    if kind == "amplitude":
        frequency, amplitude = run.lines[index]
        inside = (frequency >= points[0]) & (frequency <= points[-1])
        return float(np.max(amplitude[inside] / limit_at(frequency[inside], mask)))
    if kind == "psd":
        f, density = welch(y, fs, "hann", round(fs), detrend="constant")
        inside = (f >= points[0]) & (f <= points[-1])
        return float(np.max(density[inside] / limit_at(f[inside], mask)))
    if kind == "band_peak":
        return max(
            float(np.abs(sosfilt(butter(4, (a, b), "bandpass", fs=fs, output="sos"), y - y.mean())).max()) / limit
            for a, b, limit in zip(points[:-1], points[1:], limits[:-1], strict=True)
        )
    f, density = welch(y, fs, "hann", length, detrend="constant")
    if kind == "rms":
        bands = list(zip(points[:-1], points[1:], limits[:-1], strict=True))
    else:
        number = np.arange(np.ceil(10 * np.log10(points[0])), np.floor(10 * np.log10(points[-1])) + 1)
        centre = 10.0 ** (number / 10.0)
        bands = [(c * 10**-0.05, c * 10**0.05, limit_at(c, mask)) for c in centre]
    ends = np.append(f - 0.5 * f[1], f[-1] + 0.5 * f[1])
    total = np.append(0.0, np.cumsum(density) * f[1])
    return max(float(np.sqrt(np.interp(b, ends, total) - np.interp(a, ends, total)) / limit) for a, b, limit in bands)
