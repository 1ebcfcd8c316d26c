"""Messages about a record that was read otherwise than declared, or left out."""

from __future__ import annotations

import math

from mechid.campaign import Campaign, CampaignRecord
from mechid.command import Command
from mechid.identification.contradiction.agreement import Agreement
from mechid.identification.contradiction.alternatives import ReadingScore
from mechid.identification.output_error.declaration import Reading, rate_entry
from mechid.identification.output_error.target import target_of
from mechid.units import to_si_factor, unit_words

TORQUE_UNITS = ("N*m", "mN*m", "N*cm", "uN*m", "kN*m", "gf*cm", "kgf*cm", "kgf*m", "ozf*in", "lbf*in", "lbf*ft")
"""Units in which torque is recorded."""
SAME_UNIT = 1e-6
"""How near a factor is to a unit's. Rounding of a sum of products of decimals is far below it."""


def agreement_warnings(campaign: Campaign, agreement: Agreement) -> list[str]:
    """Return a line for each record that is not as declared: what was declared, what is taken, how sure, the remedy."""
    taken = [
        _reading_line(campaign.record(name), declared, found) for name, (declared, found) in agreement.judged.items()
    ]
    return taken + [_left_out_line(name, looks) for name, looks in agreement.left_out.items()]


def _reading_line(record: CampaignRecord, declared: ReadingScore, found: ReadingScore) -> str:
    """Put one reading in words; the costs are over the record's first moments, under the others' model."""
    target = target_of(record)
    samples = found.samples
    seconds = (samples - 1) / target.base.sample_rate_hz
    what, remedy = reading_words(record, found.taken)
    unit = unit_words(record.leading)
    counted = samples * len(target.channels)
    before, after = (target.leading.sigma * math.sqrt(j.cost / counted) for j in (declared, found))
    return (
        f"record {record.name}: not followed as declared, but with {what}, and so used: under the model of the other "
        f"records the residual of its first {seconds:.3g} s is {before:.3g} {unit} RMS as declared and {after:.3g} as "
        f"used, the log-likelihood higher by {0.5 * (declared.cost - found.cost):.3g}; if that is right, write "
        f"{remedy} for it in the campaign file"
    )


def reading_words(record: CampaignRecord, taken: Reading) -> tuple[str, str]:
    """Return what is taken and declared, and what to write."""
    said, remedies = [], []
    if taken.polarity < 0:
        what = record.leading.replace("_", " ")
        said.append(f"its {what} of the other sign (polarity -1, declared +1)")
        remedies.append(f"the other sign of its {what} channel's gain (gain = -1.0 where there is none)")
    if taken.direction < 0:
        said.append("its commanded rate of the other sign")
        remedies.append("the other sign of its rate")
    if taken.scale != 1.0:
        said.append(f"torque times {taken.scale:g}")
        remedies.append(unit_remedy(record, taken.scale))
    if taken.stepping is not None:
        said.append(f"{_steps(taken.stepping, taken.microsteps)} (declared {_steps_of(record.command)})")
        remedies.append(_steps(taken.stepping, taken.microsteps))
    if taken.rate is not None:
        entry = ", ".join(f"{key} = {_rounded(value)}" for key, value in rate_entry(taken.rate).items())
        said.append(f"{entry} full steps/s (declared {_declared_rate(record.command)})")
        remedies.append(entry)
    if taken.start_angle_deg is not None:
        said.append(f"a start angle of {taken.start_angle_deg:g} deg (declared {record.command.start_angle_deg:g})")
        remedies.append(f"start_angle_deg = {taken.start_angle_deg:g}")
    if taken.time_offset_s is not None:
        value, least, most = taken.time_offset_s
        said.append(f"a time offset of about {value:.4g} s (declared {record.time_offset.value:g}), now estimated")
        remedies.append(f"time_offset_s = {{ value = {value:.4g}, min = {least:.4g}, max = {most:.4g} }}")
    return " and ".join(said), " and ".join(remedies)


def unit_remedy(record: CampaignRecord, scale: float) -> str:
    """Return what to write of a torque whose samples are to be multiplied by a scale."""
    assert record.data is not None
    factor = record.data.channel(record.leading).scale * scale
    unit = next((u for u in TORQUE_UNITS if abs(to_si_factor(u, "torque") / factor - 1.0) < SAME_UNIT), "")
    return f'unit = "{unit}" in its torque channel' if unit else f"{scale:g} times the gain of its torque channel"


def _steps(stepping: str, microsteps: int | None) -> str:
    """Return a stepping as a campaign file writes it."""
    own = f", microsteps = {microsteps}" if stepping == "micro" else ""
    return f'stepping = "{stepping}"{own}'


def _steps_of(command: Command) -> str:
    return _steps(command.stepping, command.microsteps)


def _declared_rate(command: Command) -> str:
    return ", ".join(f"{value}" for value in rate_entry(command.rate).values())


def _rounded(value: object) -> str:
    """Return a rate, or the points of a profile, to five digits."""
    if isinstance(value, list):
        return "[" + ", ".join(_rounded(one) for one in value) + "]"
    return f"{value:.5g}"


def _left_out_line(name: str, looks: str) -> str:
    """Say that a record is left out; `looks` is a clause on what it looks like beside the others' model, if any."""
    why = looks or "no other sign, direction, start angle, time offset, gain or steps make their model follow it"
    return (
        f"record {name}: left out of the fit: it contradicts the others, and {why}; look at how it was recorded, or "
        'give it use = "validate"'
    )
