"""Warnings about records that are plainly not as declared, before any search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.contradiction.agreement_text import reading_words, unit_remedy
from mechid.identification.contradiction.first_sight import POINTS, SCALES, FirstSight
from mechid.identification.output_error.declaration import Reading


def first_sight_lines(campaign: Campaign, sight: FirstSight, *, used: bool) -> list[str]:
    """Return a line for each record, or two, or all of them: what was seen, and what to write where that helps.

    Parameters
    ----------
    campaign : Campaign
    sight : FirstSight
    used : bool
        Whether single records are read so in what follows.
    """
    lines = [_common(campaign, sight)] if sight.common_scale != 1.0 else []
    lines += [_far_off(sight.level)] if sight.level else []
    lines += [_failing(sight.failing)] if sight.failing else []
    lines += [_low_passed(sight.cut_off_hz)] if sight.cut_off_hz else []
    for name, taken in sight.otherwise.items():
        doubtful = name in sight.doubtful
        if taken.swapped is None:
            rivals = sight.rivals.get(name, ())
            lines.append(_single(campaign.record(name), taken, rivals, used=used and not doubtful, doubtful=doubtful))
        elif name < taken.swapped:
            lines.append(_swapped(name, taken.swapped, used=used and not doubtful))
    return lines + [_unexplained(name) for name in sorted(sight.unexplained)]


def _common(campaign: Campaign, sight: FirstSight) -> str:
    record = next(r for r in campaign.estimated if r.leading == "torque")
    remedies = " or ".join(unit_remedy(record, scale) for scale in (sight.common_scale, *sight.rival_scales))
    return (
        f"all records: their torque is about {1.0 / sight.common_scale:.3g} times what the mechanism at any of its "
        f"starts gives; mechid does not change all records by itself: write {remedies}, or look for a wrong unit in "
        "the mechanism file"
    )


def _far_off(level: float) -> str:
    """Say that all records are of another size than the model, without a cause."""
    size = "far larger" if level > 0.0 else "far smaller"
    return (
        f"all records: their torque is {size} than what the mechanism at any of its starts gives, and no usual unit of "
        "torque makes their first steps fit: look at how their numbers were read (raw counts, a scale factor, decimal "
        "and thousands marks), or for a wrong unit in the mechanism file"
    )


def _unexplained(name: str) -> str:
    """Say that a record is not as declared, without a cause."""
    return (
        f"record {name}: its spectrum is not that of its declaration, and no other rate, stepping or unit that was "
        "tried makes its first steps fit: look at how its numbers and times were read (mechid look), and at what the "
        "campaign file says of it"
    )


def _failing(points: int) -> str:
    return (
        f"all records: at {points} of {POINTS} starts within the bounds the model swings so fast that it cannot be "
        "simulated: look for a wrong unit in the mechanism file, of a value or of its bounds"
    )


def _low_passed(cut_off_hz: Mapping[str, float]) -> str:
    """Say from where on records fall; the frequency is that of a coarse grid, and mostly above the filter's own."""
    names, hz = ", ".join(cut_off_hz), max(cut_off_hz.values())
    return (
        f"record{'s' * (len(cut_off_hz) > 1)} {names}: the spectrum falls as behind a low-pass below about {hz:g} "
        "Hz, and the mechanism file declares none: if the recorder or its amplifier has one, write [anti_alias] with "
        "order and frequency (rad/s) in the mechanism file, or record through a wider one"
    )


def _single(record: CampaignRecord, taken: Reading, rivals: Sequence[Reading], *, used: bool, doubtful: bool) -> str:
    said, remedy = reading_words(record, taken)
    others = " or ".join(reading_words(record, rival)[0] for rival in rivals) or _rival(taken)
    then = ", and so used" if used else f", or of {others}" if doubtful else ""
    return (
        f"record {record.name}: its spectrum is not that of its declaration, but that of a record with {said}{then}; "
        f"if that is right, write {remedy} for it in the campaign file"
    )


def _rival(taken: Reading) -> str:
    """Return what a record may be as well."""
    if taken.scale == 1.0:
        return "half or twice that rate"
    rival = next(s for s in SCALES if s != taken.scale and (s > 1.0) == (taken.scale > 1.0))
    return f"torque times {rival:g}"


def _swapped(one: str, other: str, *, used: bool) -> str:
    then = ", and so used" if used else ""
    return (
        f"records {one} and {other} seem to be swapped: the spectrum of each is that of the other's "
        f"command{then}; if that is right, exchange their files in the campaign file"
    )
