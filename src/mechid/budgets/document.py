"""Budget document: verdict, requirements, modes of operation, crossings, coupling and basis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.budgets.basis import basis_table
from mechid.budgets.figures import budget_figures, emission_figure, figure_name, is_gain_known
from mechid.budgets.files import EMISSION, HARMONICS, budget_texts
from mechid.budgets.hdf5 import is_available, write_hdf5
from mechid.budgets.numbers import budget_numbers
from mechid.budgets.prediction_figures import predicts
from mechid.budgets.tables import (
    TEXTS,
    crossing_table,
    emission_requirement_table,
    emission_table,
    mode_facts,
    mode_table,
    named_table,
    requirement_table,
    share_table,
    side_table,
    steady_table,
)
from mechid.budgets.texts import add_texts
from mechid.budgets.verdict import budget_verdict, coupling_lines
from mechid.budgets.verification import budget_report
from mechid.ink.data import Data
from mechid.ink.document import IN_DOCUMENTS, ON_TERMINAL, Document, Facts, Lines, Part, Picture, Rows, Section, Words
from mechid.ink.page_rules import COMPACT, ONE_COLUMN
from mechid.ink.presenter import Presenter
from mechid.ink.text_table import PAGE

SHOWN_CROSSINGS = 12
"""Number of crossings on a terminal."""
RULE = (
    "A requirement is met where the **lower 95 % limit of its margin** is above 0: the bold number decides. The "
    "two-way margin decides where it was computed, else the one-way margin; its coupling and the margin with its 95 % "
    "interval are listed with it. Level: the quantile of the error at the requirement's confidence, from its own "
    "distribution, for the coupling that decides, at the worst rate, errors of other sources included; two-way it is "
    "the one-way level scaled as the nominal unit's level is. ± σ: from the covariance of the parameters, the values "
    "given as uncertain, the model error on validation records, and the sampling error of the ensemble, which is also "
    "listed separately."
)
EMISSION_RULE = (
    "The torque on a held base at every steady rate of the modes. Pass: the upper bound of every value is below its "
    "limit. Fail: a lower bound is above it. Pass not shown: the limit lies between the bounds. Not decidable: so it "
    "does, and noise of the records may hide as much; or the quantity is not predicted. The bounds hold the errors of "
    "the parameters and the torque that the model lacks."
)
SHARES = (
    "Shares in the variance of each level. With correlated parameters one may be negative: it offsets others. Nominal "
    "unit and other sources alone are levels over time of the nominal unit; the level above and the one-way level "
    "here are levels over the ensemble, by the requirement's interpretation. For a temporal interpretation it is the "
    "level of the member that the stated share of members does not exceed."
)
COURSE = (
    "From rest through the profile: the line of sight with its reaction to the load's acceleration, and its RMS about "
    "the mean in windows."
)
STEADY = (
    "Rates at which there is more than one steady motion, or one that repeats only after several periods of two steps, "
    "or never, or in which the rotor does not follow the command. “Rising” and “falling” start from a steady motion at "
    "the next lower or higher rate. The multiplier is the factor by which a deviation shrinks when the motion repeats; "
    "the levels use the worse motion."
)
ONE_STEADY = (
    "One at each rate, reached both from rest and from the neighbouring rates; it repeats every two steps, and "
    "the slowest transient falls to 1/e in {0}."
)
THIRD_OCTAVES = (
    "RMS in third octaves at the rate of the largest bound: the modelled torque, the unmodelled torque in the "
    f"residuals of the records, and the 95 % bound of both together. Every rate is in {EMISSION}, every line "
    f"with its bound in {HARMONICS}."
)
NAMED = (
    "Orders that the mechanism file names, as those of its tooth meshes. A mesh has further lines, whole orders of the "
    "step rate away; harmonics.csv has all of them at every rate."
)
BESIDE = (
    "Lines measured on the bench: those whose phase to the torque's line is known add to it, the others by their "
    "magnitude, in phase with the rest, as a bound. Everything else shown here except the torque itself includes all "
    "of them. Every rate is in components.csv."
)
MEETS = "Where an order of the step rate (1: one line per full step) meets a mode, within the requested rates."
CRITERION = (
    "One-way, the torque on a held base goes through the structure. Two-way, the structure's modes up to {0:g} Hz are "
    "joined with the mechanism and both move. One-way suffices where the driving-point receptance R times the "
    "mechanism's dynamic stiffness K is far below 1, since the torque on a moving base is that of a held one divided "
    "by 1 − R K."
)
NO_AVOIDED = "At no rate does the upper end of a level's band exceed its limit."
STYLE = """
.met { color: var(--good); font-weight: 600; } .exceeded { color: var(--bad); font-weight: 600; }
.not-sure { color: var(--caution); font-weight: 600; }
@media (max-width: 640px) {
  .scroll td.word { min-width: 5.5rem; } table.cards td { text-align: right; }
  table.cards td[data-label]::before { white-space: nowrap; flex: none; }
}
@media (min-width: 641px) {
  .scroll thead th { white-space: normal; }
  .scroll td.word { overflow-wrap: anywhere; min-width: 5.5rem; } .scroll td.shares { min-width: 13rem; }
}
@media print { h2[id^="mode-"] { break-before: page; } }
"""


def budget_document(data: Data) -> Document:
    """Return the document of the numbers of `budget_numbers`."""
    data = add_texts(data)
    of_modes = "Modes of operation, at the rate of the largest one-way line-of-sight RMS in full steps/s"
    return Document(
        title=f"Microvibration budget: {data['file']}",
        command="mechid budget",
        under=f"Estimate {data['estimate']}, structure {data['structure']}, line of sight "
        + ", ".join(data["line_of_sight"]),
        tab=data["file"],
        is_synthetic=bool(data["synthetic"]),
        parts=(
            budget_verdict(data),
            _requirements(data),
            _emission_requirements(data["emission_requirements"]),
            Section(of_modes, (Rows(mode_table(data)),), where=TEXTS),
            *map(_mode, data["modes"]),
            _crossings(data["crossings"]),
            _coupling_section(data),
            Section("Basis", (Rows(basis_table(data)),), "basis", "Basis", where=IN_DOCUMENTS),
            Lines(data["notes"], "note", where=ON_TERMINAL),
        ),
    )


def _requirements(data: Data) -> Section:
    if not data["requirements"]:
        if data["emission_requirements"]:
            return Section("", ())
        none = Words("No requirement is given.", where=IN_DOCUMENTS)
        return Section("Requirements", (none,), "requirements", "Requirements")
    in_short = "At the worst rate of each; the lower 95 % limit of a margin decides, two-way where it was computed."
    drivers = (
        Words(SHARES),
        Picture(figure_name("shares"), "Shares of the parameters in the variance of each level"),
        Rows(share_table(data)),
    )
    parts = (
        Words(RULE, where=IN_DOCUMENTS),
        Words(in_short, where=ON_TERMINAL),
        Rows(requirement_table(data)),
        Picture(figure_name("requirements"), "Level of each requirement as a share of its limit"),
        Section("Parameters that drive the margin", drivers, where=IN_DOCUMENTS),
    )
    return Section("Requirements", parts, "requirements", "Requirements")


def _emission_requirements(rows: list[Data]) -> Section:
    """Return the verdicts on the torque at the interface; empty without requirements on it."""
    if not rows:
        return Section("", ())
    pictures = [
        Picture(figure_name(emission_figure(k)), f"{one['name']} over the step rate")
        for k, one in enumerate(rows)
        if predicts(one)
    ]
    parts: tuple[Part, ...] = (
        Rows(emission_requirement_table(rows)),
        Words(EMISSION_RULE, where=IN_DOCUMENTS),
        *pictures,
    )
    return Section("Emission at the interface", parts, "emission", "Emission")


def _mode(mode: Data) -> Section:
    return Section(mode["name"], list(_of_mode(mode)), f"mode-{mode['key']}", mode["name"])


def _of_mode(mode: Data) -> Iterator[Part]:
    """Yield the parts of a mode's section; on a terminal it has only the table of components."""
    text, duty = mode["text"], "" if mode["duty"] is None else f"; {mode['text']['duty']} of the time"
    yield Words(f"{text['stepping']} stepping; {text['driven']}{duty}", "soft", where=IN_DOCUMENTS)
    yield Facts(mode_facts(mode), where=(PAGE,))
    if mode["kind"] == "profile":
        yield Words(COURSE, where=IN_DOCUMENTS)
        yield _picture(mode, "course", "Line of sight and its windowed RMS over the profile of")
        return
    if len(mode["rates"]) > 1:
        yield from _over_rate(mode)
    is_one = not mode["steady_rows"]
    words = Words(ONE_STEADY.format(text["slowest"]) if is_one else STEADY)
    yield Section("Steady states", (words, Rows(steady_table(mode))), where=IN_DOCUMENTS)
    envelope = _picture(mode, "envelope", "Largest torque line by third octave of")
    bands = (Words(THIRD_OCTAVES), Rows(emission_table(mode))) if mode["emission_rows"] else ()
    yield Section("Envelope of the torque over frequency", (envelope, *bands), where=IN_DOCUMENTS)
    if mode["named_rows"]:
        named = (Words(NAMED, where=IN_DOCUMENTS), Rows(named_table(mode)))
        yield Section(f"Lines of named orders, at {text['worst_rate']} steps/s", named)
    if mode["side_rows"]:
        beside = (Words(BESIDE, where=IN_DOCUMENTS), Rows(side_table(mode)))
        yield Section(f"Forces and moments beside the torque, at {text['worst_rate']} steps/s", beside)
    lines = _picture(mode, "line_of_sight", "Line of sight over time, its lines and cumulative RMS of")
    yield Section(f"Line of sight at {text['worst_rate']} steps/s, one-way", (lines,), where=IN_DOCUMENTS)


def _over_rate(mode: Data) -> Iterator[Section]:
    """Yield the sections of figures over the rate."""
    coupling = mode["over_rate"]["decided"]["coupling"]
    dashed = "; the one-way curves are dashed" if coupling == "two-way" else ""
    avoided = [
        f"Rates to avoid for “{name}”: {', '.join(f'{low:.4g} to {high:.4g}' for low, high in ranges)} steps/s."
        for name, ranges in mode["avoid"].items()
        if ranges
    ]
    said = f"Levels, bands and ranges are {coupling}, which decides{dashed}."
    words = Words(" ".join([*(avoided or [NO_AVOIDED]), said]))
    for heading, kind, caption in (
        ("Worst-case envelope over the rate", "rates", "Line of sight and levels over the rate of"),
        ("Speed-harmonic map of the torque", "map", "Torque amplitude over rate and order of"),
        ("Campbell diagram", "campbell", "Torque lines, orders and modes over the rate of"),
        ("Waterfall", "waterfall", "Torque lines over frequency, rate after rate, of"),
    ):
        picture = _picture(mode, kind, caption)
        yield Section(heading, (words, picture) if kind == "rates" else (picture,), where=IN_DOCUMENTS)


def _picture(mode: Data, kind: str, caption: str) -> Picture:
    return Picture(figure_name(f"{mode['key']}_{kind}"), f"{caption} {mode['name']}")


def _crossings(crossings: list[Data]) -> Section:
    """Return the section of crossings; a terminal shows the first ones only."""
    more = len(crossings) - SHOWN_CROSSINGS
    parts = (
        Words(MEETS if crossings else "No order of the step rate meets a mode.", where=IN_DOCUMENTS),
        Rows(crossing_table(crossings), where=IN_DOCUMENTS),
        Rows(crossing_table(crossings[:SHOWN_CROSSINGS]), where=ON_TERMINAL),
        Words(f"{more} more in crossings.csv" if more > 0 else "", where=ON_TERMINAL),
    )
    return Section("Crossings of orders and modes", parts, "crossings", "Crossings")


def _coupling_section(data: Data) -> Section:
    picture = Picture(figure_name("coupling"), "Receptance times dynamic stiffness over frequency")
    words = Words(CRITERION.format(data["coupling"]["joined_below_hz"]))
    parts: list[Part] = [words, Lines(coupling_lines(data)), *([picture] if is_gain_known(data) else [])]
    return Section("One-way and two-way", parts, "coupling", "Coupling", where=IN_DOCUMENTS)


def _binary_files(made: Any, _data: Mapping[str, Any], folder: Any) -> list[Any]:
    return [write_hdf5(made, folder)] if is_available() else []


PRESENTER = Presenter(
    name="budget",
    numbers=budget_numbers,
    document=budget_document,
    line=lambda made: f"{len(made.modes)} modes, {len(made.file.requirements) + len(made.predictions)} requirements",
    texts=budget_texts,
    files=_binary_files,
    figures=lambda _made, data: budget_figures(data),
    style=COMPACT + ONE_COLUMN + STYLE,
    report=budget_report,
)
