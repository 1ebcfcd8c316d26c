"""What a diagnosis says, in sentences: each effect, where it acts, what to do next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.reports.diagnosis.contents import BANDS, LINES

NEXT = (
    "Where an effect makes sense for your mechanism, take it from mechanism_proposed.toml into the mechanism file and "
    "identify again; hold a record back, and see whether that is predicted better (mechid compare)."
)
APART = (
    "Where effects cannot be told apart, mechid design with --fit and --diagnosis proposes the record that tells them, "
    "if one can."
)
CANNOT_TELL = "these records cannot tell it from {0}"
ACTS = (
    "An effect's share is what the model with all effects gives less what it gives without this one, everything else "
    "fitted again: what nothing else in the model can imitate."
)
SPECTRUM = "Density of the residual, measured less modelled, of the records that the mechanism as written misses most."
DOTTED = "Dotted: the frequencies in Hz at which an effect acts most."
STRETCH = "The part of the record that the mechanism as written misses most; below, measured less modelled."
PATH_TITLE = "The path"


def sentence(one: Mapping[str, Any]) -> str:
    """Say of an effect what it explains, and from which others it cannot be told."""
    text = one["text"]
    alike = f"; {CANNOT_TELL.format(text['aliases'])}" if one["aliases"] else ""
    words = one["words"][:1].upper() + one["words"][1:]
    return (
        f"{words}: it explains {text['share_percent']} % of the misfit (chi-square "
        f"{text['chi_square']} for {one['dof']}), in the records {text['records']}{alike}."
    )


def acts_line(one: Mapping[str, Any]) -> str:
    """Say where an effect acts, in a line."""
    near = {LINES: "", BANDS: "around "}
    places = [f"{near[place['kind']]}{place['text']} Hz of {place['record']}" for place in one["places"]]
    return f"{one['name']}: at {'; '.join(places)}"


def next_lines(data: Mapping[str, Any]) -> list[str]:
    """Return what to do next, a line each."""
    return [NEXT, *([APART] if any(one["aliases"] for one in data["missing"]) else [])]
