"""Fleet document: verdict, campaigns, parameters over the units and by unit, trends, groups and changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.fleets.figures import figure_names, fleet_figures
from mechid.fleets.files import fleet_files
from mechid.fleets.numbers import fleet_data
from mechid.fleets.tables import campaign_table, parameter_table, tests_table, unit_table
from mechid.fleets.texts import fleet_texts
from mechid.fleets.verdict import fleet_verdict
from mechid.ink.data import Data
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Part, Picture, Rows, Section, Words
from mechid.ink.page_rules import COMPACT, ONE_COLUMN
from mechid.ink.presenter import Presenter
from mechid.ink.text_table import PAGE

SIMULATED = "records of this fleet were simulated, not measured."
PARAMETERS = (
    "Mean: of the units, each weighted by its own error and the spread, with the standard error of the mean. "
    "**Spread**: standard deviation from unit to unit, the errors of the estimates taken out; the 95 % interval says "
    "how well it is known. A further unit: where it lies in 19 of 20 cases. Differs: the units scatter by more than "
    "their errors. Stands off: farther from the others than their spread and its own error explain."
)
POINTS = "Points: estimates with 95 % error bars. Line and band: mean and spread. In orange: units that stand off."
UNITS = "Value ± standard error, with the reason if it is not counted. Empty: the mechanism file has no such parameter."
MARKS = (
    "The colour says how far a value lies from the mean, in the spread and its own error: blue above, orange below. "
    "Framed: stands off. Underlined with dots: near a stick/slip threshold, its error holds on one side of it only. "
    "In italics: not counted."
)
GOES_WITH = "What it goes with"
TRENDS = (
    "A straight line over each covariate. Within units: each unit has its own level, and the slope is what its "
    "campaigns have in common. A trend that was found is removed before mean, spread and units that stand off are "
    "computed."
)
GROUPS = "Means over the units of each group; in brackets, how many."
CHANGES = (
    "The difference of the two estimates of a unit, with both errors. What both share, such as a wrong supply "
    "voltage, cancels in the difference and not in its error, which is on the safe side."
)
BASIS = (
    "Counted: estimates of grade A or B of parameters that were free. What a mechanism file holds as known, what lies "
    "at a bound, what was held, and fits of grade C are shown by unit and not counted. A term that only some "
    "mechanism files have is shown and has no mean: where it is absent it was taken to be nothing.",
    "Each test of a parameter rests on its own standard error. Estimates of one unit are correlated with one another: "
    "a unit that stands off in one parameter may stand off in another for the same reason.",
    "q: the false discovery rate at which a result is a finding. Findings are those with q up to {rate}: of them at "
    "most that share is expected to be chance (Benjamini and Hochberg). Which parameters differ, trends, groups, "
    "changes of units, mean changes and units that stand off are counted each for themselves.",
    "Mean and spread: random-effects model, variance from unit to unit by Paule and Mandel, its interval by the "
    "Q-profile, intervals of means and slopes by Hartung, Knapp, Sidik and Jonkman with Student's t.",
    "Campaigns of one unit are averaged before units are compared; how far they scatter beyond their errors counts in "
    "the unit's error.",
    "Angles are compared the short way round.",
)
PICTURES = {
    "fleet_parameters": "Each parameter over the campaigns with 95 % error bars, mean, and spread as a band",
    "fleet_trends": "Parameters over the covariates with which they go, with their lines",
    "fleet_changes": "Change of each unit with its 95 % error bar, and the mean change",
}
STYLE = f"""{COMPACT}{ONE_COLUMN}
table.cards td.word, table.cards th.word {{ white-space: nowrap; }}
table.cards td.reason {{ white-space: normal; min-width: 12rem; }}
table.cards th .soft {{ font-weight: 400; }}
.found {{ color: var(--caution); font-weight: 600; }}
.failed {{ color: var(--bad); font-weight: 600; }}
table.units {{ font-size: 0.8rem; }}
table.units th.word {{ position: sticky; left: 0; background: var(--paper); }}
table.units td {{ white-space: nowrap; }}
.left-out {{ color: var(--soft); font-style: italic; }}
.near {{ text-decoration: underline dotted; text-underline-offset: 0.2em; }}
.off {{ font-weight: 700; outline: 2px solid var(--caution); outline-offset: -2px; }}
@media (max-width: 640px) {{
  table.cards th.word, table.cards td.word {{ white-space: normal; }}
  table.cards td.number, table.cards td.estimate {{ white-space: normal; text-align: right; }}
}}
"""


def fleet_document(numbers: Mapping[str, Any]) -> Document:
    """Return the document of the data of `fleet_data`."""
    data, campaigns = fleet_texts(numbers), len(numbers["campaigns"])
    version = numbers["provenance"]["versions"]["mechid"]
    return Document(
        title=f"Fleet of {len(numbers['units'])} units",
        command="mechid fleet",
        under=f"{campaigns} campaigns, each identified by itself; mechid {version}",
        tab=f"{campaigns} campaigns",
        is_synthetic=bool(numbers["synthetic"]),
        simulated=SIMULATED,
        parts=(
            fleet_verdict(numbers),
            Section("Campaigns", (Rows(campaign_table(data)),), "campaigns", "Campaigns"),
            *_parameters(data),
            Section(
                "What it goes with", tuple(_covariates(data)), "goes-with", "What it goes with", where=IN_DOCUMENTS
            ),
            Section("Changes", tuple(_changes(data)), "changes", "Changes", where=IN_DOCUMENTS),
            Section("What it rests on", (_basis(data),), "basis", "Basis", where=IN_DOCUMENTS),
        ),
    )


def _parameters(data: Data) -> Iterator[Part]:
    if not data["parameters"]:
        return
    picture = _picture("fleet_parameters", data)
    yield Section(
        "Parameters over the units: mean, and spread without the estimates' errors",
        (
            Words(PARAMETERS, where=IN_DOCUMENTS),
            Rows(parameter_table(data)),
            *picture,
            *([Words(POINTS, "soft", where=IN_DOCUMENTS)] if picture else []),
        ),
        "parameters",
        "Parameters",
    )
    by_unit = (Words(UNITS), Words(MARKS, where=(PAGE,)), Rows(unit_table(data)))
    yield Section("Parameters by unit", by_unit, "units", "By unit", where=IN_DOCUMENTS)


def _picture(name: str, data: Data) -> list[Part]:
    """Return a picture, empty if there is nothing to draw."""
    return [Picture(name, PICTURES[name])] if name in figure_names(data) else []


def _covariates(data: Data) -> Iterator[Part]:
    if data["trends"]:
        picture = _picture("fleet_trends", data)
        yield Section("Trends", (Words(TRENDS), *picture, *_tests("trends", data)))
    if data["groups"]:
        yield Section("Groups", (Words(GROUPS), *_tests("groups", data)))


def _changes(data: Data) -> Iterator[Part]:
    if data["before_after"]:
        yield Words(CHANGES)
        yield from _picture("fleet_changes", data)
        if data["mean_changes"]:
            yield Section("Mean over the units", tuple(_tests("mean_changes", data)))
        yield Section("Unit by unit", tuple(_tests("changes", data)))


def _tests(kind: str, data: Data) -> Iterator[Part]:
    """Yield the tests that are findings; on a page also the others, folded."""
    found = [row for row in data[kind] if row["found"]]
    rest = [row for row in data[kind] if not row["found"]]
    yield Rows(tests_table(kind, found)) if found else Words("Nothing that is more than chance.")
    if rest:
        table = Rows(tests_table(kind, rest))
        yield Section(f"{len(rest)} that may be chance", (table,), is_folded=True, where=(PAGE,))


def _basis(data: Data) -> Lines:
    return Lines([line.format(rate=data["false_discovery_rate"]) for line in BASIS])


PRESENTER = Presenter(
    name="fleet",
    numbers=lambda made: fleet_data(made, made.folder),
    document=fleet_document,
    line=lambda made: f"{len(made.runs)} campaigns, {len(made.failed)} failed",
    texts=lambda _made, data: fleet_files(data),
    figures=lambda _made, data: fleet_figures(fleet_texts(data)),
    style=STYLE,
)
