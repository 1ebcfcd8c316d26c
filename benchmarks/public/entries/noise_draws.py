"""Intervals of mechid over noise draws of one campaign: same mechanism and runs, new noise, offsets and drifts.

The first draw is identified from the catalogue, the others start from its estimate. Errors of one draw are correlated,
so that single intervals say little: the squared distance of all parameters together follows a chi-square distribution.
"""

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from mechid.campaign import Campaign, load_campaign
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit

from ..maker.campaigns import TABLE, resonance_of, sizes_of, truth_of, values_of
from ..maker.measurement import measured
from ..maker.runs import runs_of, torque_of
from ..mechid_benchmark.scores import holds
from .mechid_entry import remark_of, write_files
from .task import read_task

SEED = 99


@dataclass(frozen=True)
class Draw:
    """One draw: intervals that hold, of how many; squared distance from the truth in the stated covariance."""

    held: int
    stated: int
    squared_distance: float
    remark: str

    @property
    def p_value(self) -> float:
        """Chance of a larger distance, if the stated covariance is true."""
        return float(chi2.sf(self.squared_distance, self.stated))


def draws(number: str, folder: Path, count: int) -> Iterator[Draw]:
    """Yield draws of the campaign in a folder; one with a bad record has none in them."""
    task, sizes = read_task(folder).table, sizes_of(number)
    v = values_of(truth_of(number), sizes)
    clean = {name: torque_of(v, one) for name, one in runs_of(resonance_of(number)).items()}
    with tempfile.TemporaryDirectory() as work:
        write_files(task, folder, Path(work))
        campaign = load_campaign(Path(work))
    near = None
    for k in range(count):
        rng = np.random.default_rng((SEED, k))
        noisy = {
            name: measured(torque, own, noise=TABLE[number].noise, mains_Nm=sizes.get("mains_Nm", 0.0))
            for (name, torque), own in zip(clean.items(), rng.spawn(len(clean)), strict=True)
        }
        fit = identify(_with_records(campaign, noisy), workers=1, near=near)
        near = near or {name: one.value for name, one in fit.parameters.items()}
        yield draw_of(fit, truth_of(number))


def _with_records(campaign: Campaign, series: Mapping[str, np.ndarray]) -> Campaign:
    records = []
    for record in campaign.records:
        (channel,) = record.data.channels
        data = replace(record.data, channels=(replace(channel, data=series[record.name]),))
        records.append(replace(record, data=data))
    return replace(campaign, records=tuple(records))


def draw_of(fit: Fit, truth: Mapping[str, float]) -> Draw:
    """Return the draw of a fit; parameters without a standard error are not stated."""
    names = [name for name in fit.correlation_names if name in truth and fit.parameters[name].ci95]
    at = [fit.correlation_names.index(name) for name in names]
    off = np.array([fit.parameters[name].value - truth[name] for name in names])
    turns = np.array([name.endswith("_deg") for name in names])
    off = np.where(turns, (off + 180.0) % 360.0 - 180.0, off)
    z = off / np.array([fit.parameters[name].std_error for name in names])
    squared = float(z @ np.linalg.solve(np.asarray(fit.correlation)[np.ix_(at, at)], z))
    held = sum(holds(name, fit.parameters[name].ci95, truth[name]) for name in names)
    return Draw(held, len(names), squared, remark_of(fit))


def summary(found: list[Draw]) -> str:
    """Return the coverage, and the distances of all draws together."""
    held, stated = sum(one.held for one in found), sum(one.stated for one in found)
    squared = sum(one.squared_distance for one in found)
    return (
        f"{held} of {stated} intervals hold ({100.0 * held / stated:.1f} %); fewest in a draw "
        f"{min(one.held for one in found)}; mean squared distance {squared / len(found):.1f} of "
        f"{stated / len(found):.1f} parameters, p of all together {chi2.sf(squared, stated):.3f}"
    )
