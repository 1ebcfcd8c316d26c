"""Torque reserve against step loss, with and without a table.

The reserve at a rate is the dry friction at the rotor that may be added before steps are lost, in a run that rises
slowly to this rate, is held for a while and stops (`designs.step_loss.drive`): the pull-out torque that is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import RateProfile
from mechid.designs.step_loss import add_friction, drive
from mechid.plant.mechanism import Mechanism
from mechid.plant.stepper import HOLDING
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_command import table_command


@dataclass(frozen=True)
class Reserve:
    """Torque reserve at a rate.

    Attributes
    ----------
    rate : float
        Full steps/s.
    nominal_Nm, table_Nm : float
        Of the nominal table and of the found one.
    """

    rate: float
    nominal_Nm: float
    table_Nm: float

    @property
    def share(self) -> float:
        """Reserve relative to that of the nominal table; 1 where neither has any."""
        return self.table_Nm / self.nominal_Nm if self.nominal_Nm > 0.0 else 1.0


def reserves(mechanism: Mechanism, base: FloatArray, table: FloatArray, rates: Sequence[float]) -> tuple[Reserve, ...]:
    """Return the torque reserves at rates in full steps/s."""
    return tuple(
        Reserve(rate, torque_reserve(mechanism, base, rate), torque_reserve(mechanism, table, rate)) for rate in rates
    )


def torque_reserve(mechanism: Mechanism, table: FloatArray, rate: float) -> float:
    """Return the dry friction in N m that may be added at the rotor, to 1 % of the holding torque; 0 if it slips."""
    slow = RateProfile.through([(0.0, 0.0), (QUIET.reserve_ramp_s, rate)])
    command, seconds = replace(table_command(table, rate), rate=slow), QUIET.reserve_ramp_s + QUIET.reserve_s

    def holds(torque: float) -> bool:
        return not drive(add_friction(mechanism, torque), command, seconds, torque=False).lost

    most = mechanism.scale(HOLDING)
    if not most or not holds(0.0):
        return 0.0
    # From above: below the pull-out torque single values fail in a resonance of the ramp, and which ones is chance.
    width = most / QUIET.reserve_levels
    levels = [k * width for k in range(QUIET.reserve_levels, 0, -1)]
    good = next((level for level in levels if holds(level)), 0.0)
    bad = good + width
    while bad - good > QUIET.reserve_resolution * most:
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def least_fundamental(mechanism: Mechanism, nominal: Sequence[float], least_share: float) -> float:
    """Return the fundamental, relative to the nominal table, that keeps a share of its reserves in N m.

    The torque that a table's fundamental V can give is V H less the losses at a rate, H the holding torque, so that a
    reserve N of the nominal table falls to s N at V = 1 - (1 - s) N / H. Harmonics give no mean torque.
    """
    holding = mechanism.scale(HOLDING)
    return 1.0 - (1.0 - least_share) * min(nominal) / holding if holding else least_share


def reserve_rule(
    mechanism: Mechanism, base: FloatArray, rates: Sequence[float], least_share: float
) -> Callable[[FloatArray], bool]:
    """Return the rule that a table, (4 n, 2), keeps a share of the nominal reserve at all rates."""
    nominal = {rate: torque_reserve(mechanism, base, rate) for rate in rates}

    def keeps(table: FloatArray) -> bool:
        return all(torque_reserve(mechanism, table, rate) >= least_share * own for rate, own in nominal.items())

    return keeps


def blend_to_reserve(
    mechanism: Mechanism, base: FloatArray, table: FloatArray, rates: Sequence[float], least_share: float
) -> tuple[FloatArray, float]:
    """Return the table, moved towards the nominal one as far as the reserve requires, and the share of it kept.

    Parameters
    ----------
    mechanism : Mechanism
    base, table : (4 n, 2)
    rates : sequence of float
        Full steps/s.
    least_share : float
        Least reserve relative to that of the nominal table.
    """
    keeps_reserve = reserve_rule(mechanism, base, rates, least_share)

    def keeps(share: float) -> bool:
        return keeps_reserve(base + share * (table - base))

    if keeps(1.0):
        return table, 1.0
    good, bad = 0.0, 1.0
    while bad - good > QUIET.blend:
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if keeps(middle) else (good, middle)
    return np.asarray(base + good * (table - base), dtype=np.float64), good
