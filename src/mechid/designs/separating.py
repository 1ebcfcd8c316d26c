"""The records that tell rival explanations apart in the least test time, and what they would show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign
from mechid.designs.planned import PlannedRecord
from mechid.designs.rivals import Group
from mechid.designs.separation import CLEAR, Pair, pairs_of, predicted_torque, refitted
from mechid.designs.settings import DESIGN


@dataclass(frozen=True)
class Promise:
    """What is expected of a pair of rivals after the records proposed.

    Attributes
    ----------
    first_order, refitted : float
        By how much the chi-square of the other is above that of the true one; by a fit of what is expected.
    record : str
        In which of the records proposed the two differ most.
    rms_Nm, frequency_hz : float
        By how much they differ there after all has adjusted, and at which frequency most.
    """

    first_order: float
    refitted: float
    record: str
    rms_Nm: float
    frequency_hz: float


@dataclass(frozen=True, eq=False)
class GroupSeparation:
    """How the rivals of one group are told apart.

    Attributes
    ----------
    group : Group
    pairs : tuple of Pair
        Every two rivals that the records leave open, each one once for the truth; none where these leave one only.
    promises : tuple of Promise
        A pair each; none where no record is proposed.
    reach : float
        The least that is expected of any pair with the records that come farthest in the test time.
    far : tuple of int
        These records; where they tell the rivals apart, they are proposed.
    """

    group: Group
    pairs: tuple[Pair, ...]
    promises: tuple[Promise, ...]
    reach: float
    far: tuple[int, ...]

    @property
    def told_already(self) -> bool:
        """Whether the records that there are speak against all rivals but one, each fitted as well as it can be."""
        return not self.pairs

    @property
    def expected(self) -> float:
        """The least that is expected of any pair: by a fit where records are proposed."""
        return min((p.refitted for p in self.promises), default=self.reach)

    @property
    def clear(self) -> bool:
        """Whether the records proposed tell its rivals apart."""
        return bool(self.promises) and self.expected >= CLEAR

    def worst(self, record: int) -> float | None:
        """Return the least that is expected of any pair after one record; None where it was not looked at."""
        if not self.pairs or not all(np.all(np.isfinite(pair.shown[record])) for pair in self.pairs):
            return None
        return min(pair.expected([record]) for pair in self.pairs)


@dataclass(frozen=True, eq=False)
class Separation:
    """How the rivals of all groups are told apart.

    Attributes
    ----------
    groups : tuple of GroupSeparation
    chosen : tuple of int
        Records of the pool, proposed for it.
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
    """Return the records that tell rivals apart.

    Parameters
    ----------
    campaign : Campaign
    groups : sequence of Group
    records : sequence of PlannedRecord
    driven : (records,) of bool
        Which are looked at.
    allowed : (records,) of bool
        Which may be proposed.
    seconds : (records,)
        Test time of each.
    total_s : float
        That there is.
    workers : int
        Threads.
    """
    looked = [k for k, can in enumerate(driven) if can]
    able = np.asarray(allowed & driven)

    def looked_at(group: Group) -> GroupSeparation:
        pairs = pairs_of(campaign, group.open, [records[k] for k in looked], workers)
        whole = tuple(_spread(pair, looked, len(records)) for pair in pairs)
        far = choice(whole, able, seconds, total_s)
        return GroupSeparation(group, whole, (), _least(whole, far), far)

    found = [looked_at(group) for group in groups]
    chosen, separated = tuple[int, ...](), list[GroupSeparation]()
    for one in (one for one in found if one.pairs):
        together = [*separated, one]
        tried = choice([pair for each in together for pair in each.pairs], able, seconds, total_s)
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
    """Return a pair with what it shows at its places in the pool; the rest is not known."""
    shown: list[FloatArray] = [np.full((1, 1 + pair.known.shape[1]), np.nan)] * count
    for k, rows in zip(looked, pair.shown, strict=True):
        shown[k] = rows
    return replace(pair, shown=tuple(shown))


def choice(pairs: Sequence[Pair], allowed: BoolArray, seconds: FloatArray, total_s: float) -> tuple[int, ...]:
    """Return the records that tell the rivals of all pairs apart in the least time; else those that come farthest.

    The shortest single record that does, of these the clearest. Else records are added by what they add for a second,
    no pair counted beyond `CLEAR`, and those without which it is still clear are left out again.
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
        here = _capped(pairs, chosen)
        gains = {k: _capped(pairs, [*chosen, k]) - here for k in fits if k not in chosen and seconds[k] <= left}
        best = max(gains, key=lambda k: gains[k] / seconds[k], default=None)
        if best is None or gains[best] < DESIGN.least_chi_square:
            break
        chosen.append(best)
    enough = min(_least(pairs, chosen), CLEAR)
    for k in sorted(chosen, key=lambda k: -seconds[k]):
        rest = [j for j in chosen if j != k]
        chosen = rest if rest and _least(pairs, rest) >= enough else chosen
    return tuple(chosen) or (farthest,)


def _least(pairs: Sequence[Pair], records: Sequence[int]) -> float:
    return min((pair.expected(records) for pair in pairs), default=0.0)


def _capped(pairs: Sequence[Pair], records: Sequence[int]) -> float:
    return sum(min(pair.expected(records), CLEAR) for pair in pairs)


def _promises(
    campaign: Campaign, one: GroupSeparation, records: Sequence[PlannedRecord], chosen: Sequence[int], workers: int
) -> tuple[Promise, ...]:
    """Return what the records proposed promise of each pair, the other rival fitted to what is expected."""
    models = dict(zip(one.group.names, one.group.models, strict=True))
    torques = {name: predicted_torque(campaign, model, records, workers) for name, model in models.items()}
    promises = []
    for pair in one.pairs:
        cost, left = refitted(campaign, models[pair.against], records, torques[pair.true])
        rms = [float(np.sqrt(np.mean(e**2))) for e in left]
        most = int(np.argmax(rms))
        promises.append(
            Promise(
                pair.expected(chosen),
                cost - models[pair.true].cost,
                records[most].name,
                rms[most],
                _strongest_hz(left[most], records[most].sample_rate_hz),
            )
        )
    return tuple(promises)


def _strongest_hz(series: FloatArray, rate_hz: float) -> float:
    spectrum = np.abs(np.fft.rfft(series * np.hanning(series.size)))
    return float(np.argmax(spectrum[1:]) + 1) * rate_hz / series.size
