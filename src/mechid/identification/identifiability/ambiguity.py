"""What no record of a campaign can tell, whatever its noise: refused where it is asked for, else said."""

from __future__ import annotations

from mechid.campaign import Campaign
from mechid.errors import InputFileError

VOLTAGE = "stepper.peak_voltage"
SCALED = (VOLTAGE, "stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant")
CURRENTS = ("current_phase_a", "current_phase_b")
REMEDY = "give it as a number, or add a channel of a phase current"


def refuse_free_voltage(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m where no current is measured.

    Neither torque nor motion tells them apart: U -> c U, k_m -> c k_m, R and L -> c^2 leaves both as they are, and
    makes c times less current.

    Raises
    ------
    InputFileError
        It is so.
    """
    free = {q.name for q in campaign.mechanism.free}
    if free.issuperset(SCALED) and not _sees_current(campaign):
        raise InputFileError(
            f"{campaign.mechanism_path}: {VOLTAGE}: free together with R, L and k_m, which torque records cannot tell "
            f"apart (U -> c U, k_m -> c k_m, R and L -> c^2 gives the same torque); {REMEDY}"
        )


def ambiguity_notes(campaign: Campaign) -> tuple[str, ...]:
    """Say what no record of this kind can tell."""
    parameters = campaign.mechanism.parameters
    frame = (_frame(campaign),) if campaign.mechanism.electrical_periods else ()
    if VOLTAGE not in parameters or _sees_current(campaign):
        return frame
    voltage = (
        f"{VOLTAGE} is taken as known: without a current or voltage channel a relative error e of it "
        "enters the torque constant as e, coil resistance and inductance as 2 e, unseen."
    )
    return voltage, *frame


def _sees_current(campaign: Campaign) -> bool:
    """Tell whether the campaign estimates from a phase current."""
    return any(match.quantity in CURRENTS for record in campaign.estimated for match in record.estimated)


def _frame(campaign: Campaign) -> str:
    """Say which turns, reversals and moves give the same records."""
    mechanism = campaign.mechanism
    turning = [h for h in mechanism.harmonics if not h.of_phase]
    turned = " and ".join(f"{h.name} by -{h.orders:g} delta" for h in turning)
    phases = f" with the phases turned, of {turned}" if turning else ""
    stepped = "" if len(turning) == len(mechanism.harmonics) else "; with harmonics of the torque constant likewise"
    return (
        f"The start angle and direction of record {campaign.records[0].name} fix the frame: the same records come from "
        f"all start angles turned by delta{phases} (square waveform: delta in steps of 90 deg{stepped}), from all "
        "signs reversed with those of the phases, and from a move by whole teeth."
    )
