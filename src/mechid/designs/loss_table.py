"""Table of pull-in and pull-out rates over load inertia, friction and voltage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from mechid.command import Command
from mechid.designs.rate_limit import RateLimit
from mechid.designs.settings import RATE
from mechid.designs.step_loss import add_friction, pull_in, pull_out, scale_load, scale_supply
from mechid.identification.computation.parallel import map_tasks
from mechid.parameter import Role
from mechid.plant.mechanism import Mechanism
from mechid.plant.stepper import HOLDING

WORDS = {"V": "voltage", "A": "current", "kg m2": "load inertia"}
"""Changed quantity, by its unit."""


@dataclass(frozen=True)
class LossRow:
    """Limits of one stepping with one quantity changed.

    Attributes
    ----------
    stepping : str
    changed : str
        Changed quantity: empty, ``"load inertia"``, ``"voltage"``, ``"current"`` or ``"friction torque"``.
    to : float
        Factor on it; for friction torque the increase, N m.
    pull_in, pull_out : RateLimit
    """

    stepping: str
    changed: str
    to: float
    pull_in: RateLimit
    pull_out: RateLimit


def loss_table(mechanism: Mechanism, commands: Sequence[Command], workers: int = 1) -> tuple[LossRow, ...]:
    """Return the limits of each command's stepping over load inertia, friction torque and voltage."""
    cases = [(command, *change) for command in commands for change in _changes(mechanism)]
    return tuple(map_tasks(_row, cases, workers))


def _row(case: tuple[Command, str, float, Mechanism]) -> LossRow:
    command, changed, to, other = case
    started = pull_in(other, command)
    return LossRow(command.stepping, changed, to, started, pull_out(other, command, started))


def _changes(mechanism: Mechanism) -> Iterator[tuple[str, float, Mechanism]]:
    yield "", 1.0, mechanism
    has = mechanism.plant.names_with_role
    kinds: list[tuple[Role, tuple[float, ...], Callable[[Mechanism, float], Mechanism]]] = [
        (Role.LOAD_INERTIA, RATE.inertia_factors, scale_load),
        (Role.SUPPLY, RATE.voltage_factors, scale_supply),
    ]
    for role, factors, change in kinds:
        word = WORDS.get(mechanism.plant.declarations[has(role)[0]].unit, "") if has(role) else ""
        yield from ((word, factor, change(mechanism, factor)) for factor in factors if word)
    torque = mechanism.scale(HOLDING)
    if has(Role.DRY_FRICTION) and torque:
        added = [share * torque for share in RATE.torque_shares]
        yield from (("friction torque", T, add_friction(mechanism, T)) for T in added)
