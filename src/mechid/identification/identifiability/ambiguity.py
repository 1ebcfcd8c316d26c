"""What no record of a campaign can tell, whatever its noise: refused where it is asked for, else said."""

from __future__ import annotations

from collections.abc import Iterable

from mechid.campaign import Campaign
from mechid.command import MeasuredCommand
from mechid.errors import InputFileError
from mechid.parameter import Role

CURRENTS = ("current_phase_a", "current_phase_b")
REMEDY = "give it as a number, or add a channel of a phase current"


def refuse_free_supply(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m, or a free current beside k_m, where no current is measured.

    A supply that is known to be none is refused too, since nothing moves then.

    Neither torque nor motion tells them apart: U -> c U, k_m -> c k_m, R and L -> c^2 leaves both as they are, and
    makes c times less current.

    Raises
    ------
    InputFileError
        It is so.
    """
    powers = _powers(campaign)
    free = {q.name for q in campaign.mechanism.free}
    stepped = any(not isinstance(record.command, MeasuredCommand) for record in campaign.estimated)
    for supply in campaign.mechanism.plant.having(Role.SUPPLY):
        if stepped and supply not in free and campaign.mechanism.value(supply) == 0.0:
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply}: found 0, with which nothing moves, so that no record tells any "
                "parameter; write the driver's"
            )
        if free.issuperset(powers) and not _sees_current(campaign):
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply}: free together with {_symbols(campaign, supply)}, which "
                f"torque records cannot separate ({_scaling(campaign)} gives the same torque); {REMEDY}"
            )


def ambiguity_notes(campaign: Campaign) -> tuple[str, ...]:
    """Say what no record of this kind can tell."""
    frame = (_frame(campaign),) if campaign.mechanism.electrical_periods else ()
    supplies = () if _sees_current(campaign) else campaign.mechanism.plant.having(Role.SUPPLY)
    return (*(_supply(campaign, supply) for supply in supplies), *frame)


def _supply(campaign: Campaign, supply: str) -> str:
    """Say how an error of the supply enters what is estimated."""
    declared = campaign.mechanism.plant.declarations
    enters = [f"{declared[n].meaning} as {_times(power)}" for n, power in _others(campaign, supply).items()]
    return (
        f"{supply} counts as known: without a current or voltage channel a relative error e of it "
        f"enters {_listed(enters)}, unseen."
    )


def _powers(campaign: Campaign) -> dict[str, int]:
    """Return the parameters that follow the supply, each with its power; what is tied follows its own."""
    mechanism = campaign.mechanism
    declared = mechanism.plant.declarations.items()
    return {n: d.supply_power for n, d in declared if d.supply_power and not mechanism.parameters[n].tied_to}


def _others(campaign: Campaign, supply: str) -> dict[str, int]:
    return {n: power for n, power in _powers(campaign).items() if n != supply}


def _symbols(campaign: Campaign, supply: str) -> str:
    declared = campaign.mechanism.plant.declarations
    return _listed(declared[name].symbol for name in _others(campaign, supply))


def _scaling(campaign: Campaign) -> str:
    symbols = campaign.mechanism.plant.declarations
    return ", ".join(f"{symbols[n].symbol} -> c^{power} {symbols[n].symbol}" for n, power in _powers(campaign).items())


def _times(power: int) -> str:
    return {1: "e", -1: "-e"}.get(power, f"{power} e")


def _listed(words: Iterable[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _sees_current(campaign: Campaign) -> bool:
    """Tell whether the campaign estimates from a phase current."""
    return any(match.quantity in CURRENTS for record in campaign.estimated for match in record.estimated)


def _frame(campaign: Campaign) -> str:
    """Say which turns, reversals and moves give the same records."""
    mechanism = campaign.mechanism
    turning = [h for h in mechanism.harmonics if not h.of_phase]
    turned = " and ".join(f"{h.name} by {-h.orders:g} delta" for h in turning)
    phases = f" with the phases turned, of {turned}" if turning else ""
    stepped = "" if len(turning) == len(mechanism.harmonics) else "; with harmonics of the torque constant likewise"
    return (
        f"The start angle and direction of record {campaign.records[0].name} fix the frame: the same records come from "
        f"all start angles turned by delta{phases} (square waveform: delta in steps of 90 deg{stepped}), from all "
        "signs reversed with those of the phases, and from a move by whole teeth."
    )
