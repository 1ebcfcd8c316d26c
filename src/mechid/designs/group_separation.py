"""Choice of the records that separate alternative explanations in the least test time, and their predicted result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign
from mechid.designs.alternatives import Group
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.separation import CLEAR, Pair, pairs_of, predicted_torque, refit
from mechid.designs.settings import DESIGN


@dataclass(frozen=True)
class Promise:
    """Prediction for a pair of alternatives after the proposed records.

    Attributes
    ----------
    first_order, by_refit : float
        Chi-square of the other alternative above that of the true one, to first order and by a refit.
    record : str
        Proposed record in which the two differ most.
    rms_Nm, frequency_hz : float
        Difference in that record after all parameters have adjusted, and its strongest frequency.
    """

    first_order: float
    by_refit: float
    record: str
    rms_Nm: float
    frequency_hz: float


@dataclass(frozen=True, eq=False)
class GroupSeparation:
    """Separation of the alternatives of one group.

    Attributes
    ----------
    group : Group
    pairs : tuple of Pair
        Every ordered pair of alternatives that the records leave open; empty if only one is left.
    promises : tuple of Promise
        One per pair; empty if no record is proposed.
    reach : float
        Least expected chi-square of any pair with the most effective records in the test time.
    far : tuple of int
        These records; they are proposed if they separate the alternatives.
    """

    group: Group
    pairs: tuple[Pair, ...]
    promises: tuple[Promise, ...]
    reach: float
    far: tuple[int, ...]

    @property
    def is_resolved(self) -> bool:
        """Whether the existing records contradict all alternatives but one, each at its best fit."""
        return not self.pairs

    @property
    def expected_chi_square(self) -> float:
        """Least expected chi-square of any pair; by a fit if records are proposed."""
        return min((p.by_refit for p in self.promises), default=self.reach)

    @property
    def is_clear(self) -> bool:
        """Whether the proposed records separate the alternatives."""
        return bool(self.promises) and self.expected_chi_square >= CLEAR

    def worst(self, record: int) -> float | None:
        """Return the least expected chi-square of any pair after one record; None if it was not examined."""
        if not self.pairs or not all(np.all(np.isfinite(pair.shown[record])) for pair in self.pairs):
            return None
        return min(pair.expected_chi_square([record]) for pair in self.pairs)


@dataclass(frozen=True, eq=False)
class Separation:
    """Separation of the alternatives of all groups.

    Attributes
    ----------
    groups : tuple of GroupSeparation
    chosen : tuple of int
        Records of the pool that are proposed.
    """

    groups: tuple[GroupSeparation, ...]
    chosen: tuple[int, ...]


def separation(
    campaign: Campaign,
    groups: Sequence[Group],
    records: Sequence[PlannedRecord],
    *,
    driven: BoolArray,
    allowed: BoolArray,
    seconds: FloatArray,
    total_s: float,
    workers: int = 1,
) -> Separation:
    """Return the records that separate alternatives.

    Parameters
    ----------
    campaign : Campaign
    groups : sequence of Group
    records : sequence of PlannedRecord
    driven : (records,) of bool
        Records to examine.
    allowed : (records,) of bool
        Records that may be proposed.
    seconds : (records,)
        Test time of each.
    total_s : float
        Available test time.
    workers : int
        Number of threads.
    """
    looked = [k for k, can in enumerate(driven) if can]
    able = np.asarray(allowed & driven)

    def examine(group: Group) -> GroupSeparation:
        pairs = pairs_of(campaign, group.undecided, [records[k] for k in looked], workers)
        whole = tuple(_spread(pair, looked, len(records)) for pair in pairs)
        far = choose(whole, able, seconds, total_s)
        return GroupSeparation(group, whole, (), _least(whole, far), far)

    found = [examine(group) for group in groups]
    chosen, separated = tuple[int, ...](), list[GroupSeparation]()
    # Groups are added one by one: a group that cannot be separated in the time must not cost the others their records.
    for one in (one for one in found if one.pairs):
        together = [*separated, one]
        tried = choose([pair for each in together for pair in each.pairs], able, seconds, total_s)
        if all(_least(each.pairs, tried) >= CLEAR for each in together):
            chosen, separated = tried, together
    promised = [
        replace(one, promises=_promises(campaign, one, [records[k] for k in chosen], chosen, workers))
        if one in separated
        else one
        for one in found
    ]
    return Separation(tuple(promised), chosen)


def _spread(pair: Pair, looked: Sequence[int], count: int) -> Pair:
    """Return a pair with its results at their positions in the pool; NaN for the other records."""
    shown: list[FloatArray] = [np.full((1, 1 + pair.known.shape[1]), np.nan)] * count
    for k, rows in zip(looked, pair.shown, strict=True):
        shown[k] = rows
    return replace(pair, shown=tuple(shown))


def choose(pairs: Sequence[Pair], allowed: BoolArray, seconds: FloatArray, total_s: float) -> tuple[int, ...]:
    """Return the records that separate all pairs in the least time, or else the most effective ones.

    The shortest single record that suffices is taken, of equally short ones the clearest. Otherwise records are added
    by their gain per second, with each pair counted up to `CLEAR`, and records that turn out unnecessary are removed
    again.
    """
    fits = [int(k) for k in np.flatnonzero(allowed & (seconds <= total_s))]
    if not pairs or not fits:
        return ()
    alone = {k: _least(pairs, [k]) for k in fits}
    if clear := [k for k in fits if alone[k] >= CLEAR]:
        return (min(clear, key=lambda k: (seconds[k], -alone[k])),)
    chosen: list[int] = []
    farthest = max(fits, key=lambda k: alone[k])
    while _least(pairs, chosen) < CLEAR:
        left = total_s - float(sum(seconds[k] for k in chosen))
        here = _capped_sum(pairs, chosen)
        gains = {k: _capped_sum(pairs, [*chosen, k]) - here for k in fits if k not in chosen and seconds[k] <= left}
        best = max(gains, key=lambda k: gains[k] / seconds[k], default=None)
        if best is None or gains[best] < DESIGN.least_chi_square:
            break
        chosen.append(best)
    # Where the set falls short of `CLEAR`, removing a record must not lower its reach.
    enough = min(_least(pairs, chosen), CLEAR)
    for k in sorted(chosen, key=lambda k: -seconds[k]):
        rest = [j for j in chosen if j != k]
        chosen = rest if rest and _least(pairs, rest) >= enough else chosen
    return tuple(chosen) or (farthest,)


def _least(pairs: Sequence[Pair], records: Sequence[int]) -> float:
    return min((pair.expected_chi_square(records) for pair in pairs), default=0.0)


def _capped_sum(pairs: Sequence[Pair], records: Sequence[int]) -> float:
    return sum(min(pair.expected_chi_square(records), CLEAR) for pair in pairs)


def _promises(
    campaign: Campaign, one: GroupSeparation, records: Sequence[PlannedRecord], chosen: Sequence[int], workers: int
) -> tuple[Promise, ...]:
    """Return the prediction for each pair, with the other alternative fitted to the expected records."""
    models = dict(zip(one.group.names, one.group.models, strict=True))
    torques = {name: predicted_torque(campaign, model, records, workers) for name, model in models.items()}
    promises = []
    for pair in one.pairs:
        cost, left = refit(campaign, models[pair.against], records, torques[pair.true])
        rms = [float(np.sqrt(np.mean(e**2))) for e in left]
        most = int(np.argmax(rms))
        promises.append(
            Promise(
                pair.expected_chi_square(chosen),
                cost - models[pair.true].cost,
                records[most].name,
                rms[most],
                _strongest_hz(left[most], records[most].sample_rate_hz),
            )
        )
    return tuple(promises)


def _strongest_hz(series: FloatArray, rate_hz: float) -> float:
    # The window keeps a slow drift from leaking over the lines.
    spectrum = np.abs(np.fft.rfft(series * np.hanning(series.size)))
    # Bin 0 is the mean, not a line.
    return float(np.argmax(spectrum[1:]) + 1) * rate_hz / series.size
