"""What is said of records that are plainly not as declared, before any search."""

from __future__ import annotations

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.contradiction.agreement_text import reading_words
from mechid.identification.contradiction.first_sight import FirstSight
from mechid.identification.output_error.declaration import Taken
from mechid.units import to_si_factor

SPELLED = ("N*m", "mN*m", "N*cm")


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
        f"mechid does not change all records by itself: {unit_remedy(record, scale)}, or look for a wrong unit in the "
        "mechanism file"
    )


def _single(record: CampaignRecord, taken: Taken, *, used: bool, doubtful: bool) -> str:
    said, remedy = reading_words(record, taken)
    then = ", and so used" if used else ", or of half or twice that rate" if doubtful else ""
    return (
        f"record {record.name}: its spectrum is not that of its declaration, but that of a record with {said}{then}; "
        f"if that is right, write {remedy} for it in the campaign file"
    )


def _swapped(one: str, other: str, *, used: bool) -> str:
    then = ", and so used" if used else ""
    return (
        f"records {one} and {other} seem to be swapped: the spectrum of each is that of the other's "
        f"command{then}; if that is right, exchange their files in the campaign file"
    )


def unit_remedy(record: CampaignRecord, scale: float) -> str:
    """Return what to write of a torque whose samples are to be multiplied by a scale."""
    assert record.data is not None
    factor = record.data.channel(record.leading).scale * scale
    unit = next((u for u in SPELLED if abs(to_si_factor(u, "torque") / factor - 1.0) < 1e-6), "")
    return (
        f'write unit = "{unit}" for the torque channel' if unit else f"multiply the torque channel's gain by {scale:g}"
    )
