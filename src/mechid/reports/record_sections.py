"""Sections on the records: all of them in a table, then each with its figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from mechid.ink.document import IN_DOCUMENTS, ON_TERMINAL, Facts, Interactive, Part, Picture, Rows, Section, Words
from mechid.ink.quantities import has_only_torque, quantity_words
from mechid.ink.text_table import PAGE
from mechid.reports.outline import DETAIL_S, Outline
from mechid.reports.payload import zooms
from mechid.reports.tables import followed_table, record_table
from mechid.reports.use import held_out, left_out
from mechid.units import unit_words
from mechid.validations.tables import order_table, order_table_of_one, validation_table

if TYPE_CHECKING:
    from mechid.reports.curves import Curves

RECORDS = (
    "How each record is predicted over its whole length, offset and drift removed. Whiteness by Ljung and Box over 25 "
    "lags: p is the chance of such a residual from white noise, ρ the largest autocorrelation."
)
FOLLOWED = "Residual, noise and offset in N m, drift in N m/s"
FOLLOWED_BY_CHANNEL = "By channel; residual, noise and offset in the unit, drift in the unit a second"
HELD_OUT = "Prediction of the records held out"
LEFT_OUT = "Records to estimate from that were left out, because they contradict the others"
ORDERS = "At orders of the step rate (1: once a full step); amplitudes in {}, RMS over windows"
OUTLINED = (
    "A long record: the figure shows the least and the largest sample of every {column:.3g} s of it, and every sample "
    "of {detail:.3g} s around what the buttons name."
)
USES = {
    "validate": "; **held out of the fit**",
    "left out": "; **left out of the fit, although the campaign file gives it to estimate from: it contradicts the "
    "others**",
}


def record_parts(data: Mapping[str, Any], curves: Sequence[Curves]) -> Iterator[Part]:
    """Yield the parts on the records, for documents and for a terminal.

    Parameters
    ----------
    data : mapping
    curves : sequence of Curves
        Curves of the records in order, each beginning with its leading channel.
    """
    said = FOLLOWED if has_only_torque(data["channels"]) else FOLLOWED_BY_CHANNEL
    parts: list[Part] = [Words(RECORDS, where=IN_DOCUMENTS), Rows(followed_table(data), said, where=ON_TERMINAL)]
    if "record_table" in data:
        parts.append(Rows(record_table(data), where=IN_DOCUMENTS))
    yield Section("Records", parts, "records", "Records")
    yield from _predictions(data)
    # Only the curves of a leading channel bear the plain name of their record.
    firsts = [k for k, one in enumerate(curves) if one.name == one.record]
    sections = [_record(data, curves[first:end]) for first, end in pairwise((*firsts, len(curves)))]
    yield Section("", sections, entry="records", where=IN_DOCUMENTS)


def _predictions(data: Mapping[str, Any]) -> Iterator[Section]:
    """Yield, for a terminal, the prediction of the records that were not fitted."""
    for rows, words in ((held_out(data["validation"]), HELD_OUT), (left_out(data["validation"]), LEFT_OUT)):
        yield Section(f"{words}; residual in {_unit(rows)}", (Rows(validation_table(rows)),), where=ON_TERMINAL)
    orders = held_out(data["orders"])
    yield Section(ORDERS.format(_unit(orders)), (Rows(order_table(orders)),), where=ON_TERMINAL)


def _unit(rows: Sequence[Mapping[str, Any]]) -> str:
    return "N m" if has_only_torque(rows) else "the unit"


def _record(data: Mapping[str, Any], curves: Sequence[Curves]) -> Section:
    """Return the section of a record: its command, its leading channel, and its other channels."""
    leading, *others = curves
    driven = data["driven"][leading.record]
    taken = ", ".join(f"{key} {value}" for key, value in driven["taken"].items())
    not_as_declared = f"; **not as declared**: {taken}" if taken else ""
    words = f"{driven['command']}; {driven['file']}{not_as_declared}{USES.get(driven['use'], '')}"
    sections = [
        Section(f"{one.record}: {quantity_words(one.quantity)}", list(_channel(data, one)), f"record-{one.name}")
        for one in others
    ]
    parts = (Words(words, "soft"), *_channel(data, leading), *sections)
    return Section(leading.record, parts, f"record-{leading.record}", leading.record)


def _channel(data: Mapping[str, Any], one: Curves) -> Iterator[Part]:
    """Yield a channel's numbers, its figures, and its lines at orders of the step rate."""
    name, words = one.name, quantity_words(one.quantity)
    row = next(row for row in data["record_table"] if (row["name"], row["quantity"]) == (one.record, one.quantity))
    yield Words(row["words"])
    yield Facts(row["cells"], where=(PAGE,))
    if isinstance(one.trace, Outline):
        yield Words(OUTLINED.format(column=one.trace.column_s, detail=DETAIL_S), "soft", where=(PAGE,))
    stretches = [(each["label"], each["from"], each["to"]) for each in zooms(one)]
    picture = Picture(one.trace_name, f"Measured and modelled {words} of {one.record}")
    yield Interactive(picture, ("torque",), name, stretches)
    spectrum = Picture(f"{name}_spectrum", f"Amplitude spectrum of {name}")
    yield Section("Amplitude spectrum", (Interactive(spectrum, ("spectrum",), name),))
    if one.spectrogram:
        swept = Picture(f"{name}_spectrogram", f"Spectrogram of {name}")
        yield Section("Spectrogram", (Interactive(swept, ("spectrogram",), name),))
    residual = Picture(f"{name}_residual", f"Density and autocorrelation of the residual of {name}")
    whiteness = (Interactive(residual, ("density", "correlation"), name),)
    yield Section("Residual: density and whiteness", whiteness)
    orders = [row for row in data["orders"] if (row["name"], row["quantity"]) == (one.record, one.quantity)]
    yield Rows(order_table_of_one(orders), ORDERS.format(unit_words(one.quantity)))
