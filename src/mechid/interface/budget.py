"""From an estimate to the line of sight."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mechid.analysis import validate
from mechid.budgets.budget import Budget, make_budget
from mechid.budgets.budget_file import BudgetFile, budget_of_table, read_budget_file
from mechid.identification.result.estimate_file import FILE_NAME
from mechid.identification.result.fit import Fit
from mechid.interface.progress import telling
from mechid.interface.report import campaign_of
from mechid.reports.fit.numbers import report_data
from mechid.reports.fit.results import write_results
from mechid.structure import Structure


def budget(
    source: Path | str | Mapping[str, Any],
    *,
    fit: Fit | None = None,
    structure: Structure | None = None,
    workers: int = 1,
    executor: Executor | None = None,
    say: Callable[[str], None] | None = None,
) -> Budget:
    """Predict the line of sight's error against requirements.

    Parameters
    ----------
    source : Path or mapping
        BUDGET.toml, or the tables that it would hold (docs/budget.md): ``flight``, ``structure``, ``mode``,
        ``requirement``, ``error``; names of files are taken from the working folder then.
    fit : Fit or None
        What flies, in place of the file that ``estimate`` names; it holds its campaign.
    structure : Structure or None
        What it is mounted on, in place of the file that ``structure`` names.
    workers : int
        Threads.
    executor : concurrent.futures.Executor or None
        Whose workers do the work, as `distributed.Client.get_executor()`; None leaves it to threads.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.

    Returns
    -------
    Budget
        Torques in N m, lines of sight in rad.

    Raises
    ------
    InputFileError
        The file or table, its estimate or structure is missing or wrong.
    UsageError
        A profile is shorter than a requirement's windows, or the fit does not hold its campaign.
    FitError
        The mechanism diverged.

    Examples
    --------
    >>> import mechid
    >>> made = mechid.budget("mechid-demo/budget.toml")  # doctest: +SKIP
    >>> [standing.level.estimate_rad for standing in made.standings]  # doctest: +SKIP
    """
    if isinstance(source, Mapping):
        asked = budget_of_table(source, structure=structure, has_estimate=fit is not None)
    else:
        asked = read_budget_file(source, structure=structure, has_estimate=fit is not None)
    with telling(say) as tell:
        if fit is None:
            return make_budget(asked, workers, tell, executor=executor)
        with TemporaryDirectory(prefix="mechid_budget_") as aside:
            here = replace(asked, estimate=_left(fit, Path(aside)))
            made = make_budget(here, workers, tell, executor=executor)
    return replace(made, file=_named(made.file))


def _left(fit: Fit, folder: Path) -> Path:
    """Leave in a folder what identify leaves of a fit, and return its estimate."""
    validation = validate(campaign_of(fit, None), fit)
    write_results(fit, report_data(fit, validation=validation), folder, validation=validation)
    return folder / FILE_NAME


def _named(asked: BudgetFile) -> BudgetFile:
    """Return what was asked for with the estimate called by its name alone: its folder is gone."""
    return replace(asked, estimate=Path(FILE_NAME))
