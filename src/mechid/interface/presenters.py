"""Presenters of the kinds of results that have no document yet; those that have one stand in `mechid.shown`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
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


def _trajectory() -> Presenter:
    from mechid.campaign.trajectory_file import write_trajectories
    from mechid.reports.simulated import print_simulated, simulated_data

    return Presenter(
        numbers=lambda run: simulated_data({"": run}, {}),
        ink=lambda data, console, files: print_simulated(data, console),
        files=lambda run, data, folder: [*write_trajectories({"trajectory": run}, folder).values()],
        line=lambda run: f"{', '.join(run.values)}: {run.time.size} samples, {run.outcome.name.lower()}",
    )


PRESENTERS: Mapping[str, Callable[[], Presenter]] = {
    "Trajectory": _trajectory,
}
