"""Descriptions of commands for reports."""

from __future__ import annotations

from mechid.command.measured import MeasuredCommand
from mechid.command.rate import RateProfile
from mechid.command.stepping import Command

STEPPING_WORDS = {"full": "full stepping", "half": "half stepping", "micro": "microstepping"}
START_WORDS = {"equilibrium": "start at equilibrium", "estimated": "start estimated"}


def command_words(command: Command) -> str:
    """Return the description of a command.

    Examples
    --------
    >>> from mechid.command import RateProfile
    >>> rate = RateProfile.through([(0.0, 0.0), (60.0, 120.0)])
    >>> command_words(Command(stepping="micro", microsteps=16, rate=rate))
    'microstepping (16) at 0 to 120 full steps/s over 60 s, from 0 deg'
    """
    if isinstance(command, MeasuredCommand):
        inputs = [f"{c.quantity}, {'held' if c.held else 'straight'} between samples" for c in command.channels]
        return f"measured {' and '.join(inputs)}, from {command.start_angle_deg:.9g} deg"
    count = f" ({command.microsteps})" if command.stepping == "micro" else ""
    odd: list[str] = [command.waveform] if command.waveform != "cosine" else []
    odd += [f"by a table of {len(command.table)} values"] if command.table else []
    odd += [START_WORDS[command.start]] if command.start in START_WORDS else []
    words = f"{STEPPING_WORDS[command.stepping]}{count} at {_rate_words(command.rate)}"
    return ", ".join([words, f"from {command.start_angle_deg:.9g} deg", *odd])


def _rate_words(rate: RateProfile) -> str:
    low, high, points = min(rate.rates), max(rate.rates), len(rate.times_s)
    span = f"{low:.9g}" if low == high else f"{low:.9g} to {high:.9g}"
    through = f" through {points} points" if points > 2 else ""
    over = f" over {rate.times_s[-1]:.9g} s" if points > 1 else ""
    return f"{span} full steps/s{through}{over}"
