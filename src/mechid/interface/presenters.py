"""Presenters of each kind of result: its numbers, its ink, its files, one line of words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.holding import held
from mechid.ink.presenter import Presenter as OfDocument
from mechid.ink.presenter import printed_html, printed_text

Ink = Callable[[Mapping[str, Any], Console, Sequence[Path]], None]


@dataclass(frozen=True, kw_only=True)
class Presenter:
    """How one kind of result is shown.

    Parameters
    ----------
    data : callable
        From the result to the dict of every number shown.
    ink : callable
        Prints that dict on a console, and where files are.
    files : callable
        From the result, its dict and a folder to the files written.
    line : callable
        From the result to a line of words.
    """

    data: Callable[[Any], dict[str, Any]]
    ink: Ink
    files: Callable[[Any, Mapping[str, Any], Path], list[Path]]
    line: Callable[[Any], str]


def data_of(result: object) -> dict[str, Any]:
    """Return every number that is shown of a result."""
    return presenter_of(result).data(result)


def written(result: object, folder: Path) -> list[Path]:
    """Write a result's files into a folder, and return them."""
    own = presenter_of(result)
    with held(folder):
        return own.files(result, own.data(result), folder)


def line_of(result: object) -> str:
    """Return a result in a line of words."""
    return presenter_of(result).line(result)


def text_of(result: object) -> str:
    """Return the text that a command prints of a result."""
    return printed_text(lambda console: _print(result, console))


def html_of(result: object) -> str:
    """Return the same as HTML for a notebook."""
    return printed_html(lambda console: _print(result, console))


def show_written(result: object, folder: Path | None, console: Console) -> None:
    """Print a result as its command does, its files written into a folder where one is given."""
    own = presenter_of(result)
    data = own.data(result)
    with held(folder) if folder is not None else nullcontext():
        own.ink(data, console, own.files(result, data, folder) if folder is not None else [])


def _print(result: object, console: Console) -> None:
    own = presenter_of(result)
    own.ink(own.data(result), console, ())


def presenter_of(result: object) -> Presenter:
    """Return the presenter of a result's kind."""
    return _MAKERS[type(result).__name__]()


def _of(own: OfDocument) -> Presenter:
    """Return the presenter of a result that has a document."""
    return Presenter(data=own.numbers, ink=own.print, files=own.write, line=own.line)


def _survey() -> Presenter:
    from mechid.reports.look.contents import look_data
    from mechid.reports.look.files import write_look
    from mechid.reports.look.terminal import print_look

    return Presenter(
        data=lambda found: look_data(found.looks, [asdict(one) for one in found.left_out]),
        ink=print_look,
        files=lambda found, data, folder: write_look(data, found.looks, folder),
        line=lambda found: ", ".join(look.record.name for look in found.looks),
    )


def _understanding() -> Presenter:
    from mechid.ink.console import print_lines
    from mechid.reports.overview import campaign_data, print_campaign

    def files(found: Any, data: Mapping[str, Any], folder: Path) -> list[Path]:
        from mechid.reports.record_figures import write_record_figures  # Matplotlib takes half a second to load

        return write_record_figures(found.campaign, folder)

    def ink(data: Mapping[str, Any], console: Console, files: Sequence[Path]) -> None:
        print_campaign(data, console)
        print_lines(console, "written", map(str, files))

    return Presenter(
        data=lambda found: campaign_data(found.campaign, found.found),
        ink=ink,
        files=files,
        line=lambda found: f"{len(found.campaign.records)} records, {len(found.warnings)} warnings",
    )


def _diagnosis() -> Presenter:
    from mechid.diagnoses.document import PRESENTER

    return _of(PRESENTER)


def _comparison() -> Presenter:
    from mechid.comparisons.document import PRESENTER

    return _of(PRESENTER)


def _profiles() -> Presenter:
    from mechid.profiles.document import PRESENTER

    return _of(PRESENTER)


def _bootstrap() -> Presenter:
    from mechid.bootstraps.document import PRESENTER

    return _of(PRESENTER)


def _design() -> Presenter:
    from mechid.designs.numbers import design_data
    from mechid.reports.design.files import write_design
    from mechid.reports.design.terminal import print_design

    return Presenter(
        data=design_data,
        ink=print_design,
        files=lambda found, data, folder: write_design(found, folder, data),
        line=lambda found: ", ".join(record.name for record in found.chosen.records) or "no record",
    )


def _budget() -> Presenter:
    from mechid.budgets.files import write_budget
    from mechid.budgets.numbers import budget_data
    from mechid.reports.budget.files import write_budget_report
    from mechid.reports.budget.terminal import print_budget

    return Presenter(
        data=budget_data,
        ink=print_budget,
        files=lambda made, data, folder: [*write_budget(made, folder, data), *write_budget_report(data, folder)],
        line=lambda made: f"{len(made.modes)} modes, {len(made.file.requirements)} requirements",
    )


def _fleet() -> Presenter:
    from mechid.fleets.files import write_fleet
    from mechid.fleets.numbers import fleet_data
    from mechid.reports.fleet.files import write_fleet_report
    from mechid.reports.fleet.terminal import print_fleet

    return Presenter(
        data=lambda made: fleet_data(made, made.folder),
        ink=print_fleet,
        files=lambda made, data, folder: [*write_fleet(data, folder), *write_fleet_report(data, folder)],
        line=lambda made: f"{len(made.runs)} campaigns, {len(made.failed)} failed",
    )


def _exported() -> Presenter:
    from mechid.reports.exported import print_exported

    return Presenter(
        data=lambda done: done.to_dict() | {"folder": str(done.folder)},
        ink=lambda data, console, files: print_exported(data, console),
        files=lambda done, data, folder: [done.folder / name for name in done.written.files],
        line=lambda done: f"{done.target} in {done.folder}",
    )


def _fit() -> Presenter:
    from mechid.reports.presenter import PRESENTER

    return _of(PRESENTER)


def _trajectory() -> Presenter:
    from mechid.campaign.trajectory_file import write_trajectories
    from mechid.reports.simulated import print_simulated, simulated_data

    return Presenter(
        data=lambda run: simulated_data({"": run}, {}),
        ink=lambda data, console, files: print_simulated(data, console),
        files=lambda run, data, folder: [*write_trajectories({"trajectory": run}, folder).values()],
        line=lambda run: f"{', '.join(run.values)}: {run.time.size} samples, {run.outcome.name.lower()}",
    )


def _validations() -> Presenter:
    from mechid.validations.document import PRESENTER

    return _of(PRESENTER)


_MAKERS: Mapping[str, Callable[[], Presenter]] = {
    "Bootstrap": _bootstrap,
    "Budget": _budget,
    "Comparison": _comparison,
    "Design": _design,
    "Diagnosis": _diagnosis,
    "Exported": _exported,
    "Fit": _fit,
    "Fleet": _fleet,
    "Profiles": _profiles,
    "Survey": _survey,
    "Trajectory": _trajectory,
    "Understanding": _understanding,
    "Validations": _validations,
}
