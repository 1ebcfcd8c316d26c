"""What is said of records that are plainly not as declared, before any search."""

from __future__ import annotations

from collections.abc import Mapping

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.contradiction.agreement_text import reading_words, unit_remedy
from mechid.identification.contradiction.first_sight import POINTS, SCALES, FirstSight
from mechid.identification.output_error.declaration import Reading


def first_sight_lines(campaign: Campaign, sight: FirstSight, *, used: bool) -> list[str]:
    """Return a line for each record, or two, or all of them: what it plainly is, and what to write.

    Parameters
    ----------
    campaign : Campaign
    sight : FirstSight
    used : bool
        Whether single records are read so in what follows.
    """
    lines = [_common(campaign, sight.common_scale)] if sight.common_scale != 1.0 else []
    lines += [_failing(sight.failing)] if sight.failing else []
    lines += [_low_passed(sight.cut_off_hz)] if sight.cut_off_hz else []
    for name, taken in sight.otherwise.items():
        doubtful = name in sight.doubtful
        if taken.swapped is None:
            lines.append(_single(campaign.record(name), taken, used=used and not doubtful, doubtful=doubtful))
        elif name < taken.swapped:
            lines.append(_swapped(name, taken.swapped, used=used and not doubtful))
    return lines


def _common(campaign: Campaign, scale: float) -> str:
    record = next(r for r in campaign.estimated if r.leading == "torque")
    return (
        f"all records: their torque is about {1.0 / scale:.3g} times what the mechanism at any of its starts gives; "
        f"mechid does not change all records by itself: write {unit_remedy(record, scale)}, or look for a wrong "
        "unit in the mechanism file"
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


def _single(record: CampaignRecord, taken: Reading, *, used: bool, doubtful: bool) -> str:
    said, remedy = reading_words(record, taken)
    then = ", and so used" if used else f", or of {_rival(taken)}" if doubtful else ""
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
