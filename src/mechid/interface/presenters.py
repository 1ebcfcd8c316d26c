"""Presenters of the kinds of results that have no document yet; those that have one stand in `mechid.shown`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.holding import held
from mechid.ink.document import Document
from mechid.ink.presenter import Presenter as OfDocument

Ink = Callable[[Mapping[str, Any], Console, Sequence[Path]], None]


@dataclass(frozen=True, kw_only=True)
class Presenter(OfDocument):
    """How one kind of result is shown whose ink is written by hand."""

    name: str = ""
    document: Callable[[Mapping[str, Any]], Document] = lambda _data: Document(title="", command="", parts=())
    ink: Ink

    def write(self, result: Any, numbers: Mapping[str, Any], folder: Path) -> list[Path]:
        """Write the files of a result."""
        with held(folder):
            return self.files(result, numbers, folder)

    def print(self, numbers: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
        """Print what `numbers` made, and where its files are."""
        self.ink(numbers, console, files)


def _survey() -> Presenter:
    from mechid.reports.look.contents import look_data
    from mechid.reports.look.files import write_look
    from mechid.reports.look.terminal import print_look

    return Presenter(
        numbers=lambda found: look_data(found.looks, [asdict(one) for one in found.left_out]),
        ink=print_look,
        files=lambda found, data, folder: write_look(data, found.looks, folder),
        line=lambda found: ", ".join(look.record.name for look in found.looks),
    )


def _design() -> Presenter:
    from mechid.designs.numbers import design_data
    from mechid.reports.design.files import write_design
    from mechid.reports.design.terminal import print_design

    return Presenter(
        numbers=design_data,
        ink=print_design,
        files=lambda found, data, folder: write_design(found, folder, data),
        line=lambda found: ", ".join(record.name for record in found.chosen.records) or "no record",
    )


def _fit() -> Presenter:
    from mechid.reports.numbers import report_data
    from mechid.reports.run import report
    from mechid.reports.terminal import print_report

    return Presenter(
        numbers=report_data,
        ink=print_report,
        files=lambda fit, data, folder: report(fit, folder),
        line=lambda fit: f"grade {fit.grade}, {len(fit.correlation_names)} free parameters, {len(fit.records)} records",
    )


def _trajectory() -> Presenter:
    from mechid.campaign.trajectory_file import write_trajectories
    from mechid.reports.simulated import print_simulated, simulated_data

    return Presenter(
        numbers=lambda run: simulated_data({"": run}, {}),
        ink=lambda data, console, files: print_simulated(data, console),
        files=lambda run, data, folder: [*write_trajectories({"trajectory": run}, folder).values()],
        line=lambda run: f"{', '.join(run.values)}: {run.time.size} samples, {run.outcome.name.lower()}",
    )


def _validations() -> Presenter:
    from mechid.identification.result.estimate_file import json_text
    from mechid.reports.tables import order_table, validation_table
    from mechid.reports.validation import order_rows, validation_rows
    from mechid.writing import write_together

    def ink(data: Mapping[str, Any], console: Console, files: Sequence[Path]) -> None:
        validation_table(data["validation"]).print(console)
        if data["orders"]:
            order_table(data["orders"]).print(console)

    def files(found: Mapping[str, Any], data: Mapping[str, Any], folder: Path) -> list[Path]:
        content = {name: one.to_dict() for name, one in found.items()}
        return write_together(folder, {"validation.json": json_text(content)})

    return Presenter(
        numbers=lambda found: {"validation": validation_rows(found), "orders": order_rows(found)},
        ink=ink,
        files=files,
        line=", ".join,
    )


PRESENTERS: Mapping[str, Callable[[], Presenter]] = {
    "Design": _design,
    "Fit": _fit,
    "Survey": _survey,
    "Trajectory": _trajectory,
    "Validations": _validations,
}
