"""Supported quantities of a record, and their SI units."""

from __future__ import annotations

from collections.abc import Mapping

from mechid.errors import RecordError, did_you_mean

RATES = ("rotor_rate", "output_rate")
FORCES = ("force", "force_x", "force_y", "force_z")
TORQUES = ("torque", "moment_x", "moment_y", "moment_z")

SI_UNIT: Mapping[str, str] = {
    "time": "s",
    "torque": "N*m",
    "force": "N",
    "rotor_angle": "rad",
    "rotor_rate": "rad/s",
    "output_angle": "rad",
    "output_rate": "rad/s",
    "position": "m",
    "velocity": "m/s",
    "current": "A",
    "voltage": "V",
    "current_phase_a": "A",
    "current_phase_b": "A",
    "current_phase_c": "A",
    "current_phase_d": "A",
    "voltage_phase_a": "V",
    "voltage_phase_b": "V",
    "voltage_phase_c": "V",
    "voltage_phase_d": "V",
    **dict.fromkeys(FORCES[1:], "N"),
    **dict.fromkeys(TORQUES[1:], "N*m"),
}
"""Supported quantities of a record, each with the unit used inside mechid."""


def si_unit(quantity: str) -> str:
    """Return the SI unit of `quantity`, e.g. ``"N*m"``; raise RecordError for an unknown quantity."""
    if quantity not in SI_UNIT:
        near = did_you_mean(quantity, SI_UNIT)
        raise RecordError(f'unknown quantity "{quantity}"{near or "; known are " + ", ".join(SI_UNIT)}')
    return SI_UNIT[quantity]


def unit_words(quantity: str) -> str:
    """Return the SI unit of a quantity formatted for running text.

    Examples
    --------
    >>> unit_words("torque")
    'N m'
    """
    return si_unit(quantity).replace("*", " ")
