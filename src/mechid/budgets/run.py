"""Public function for predicting the line-of-sight error and comparing it with requirements."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechid.budgets.budget import Budget, make_budget
from mechid.budgets.budget_file import budget_of_table, read_budget_file
from mechid.identification.result.fit import Fit
from mechid.identification.result.fit_file import estimate_path, read_fit
from mechid.progress.listening import telling
from mechid.structure import Structure


def budget(
    source: Path | str | Mapping[str, Any],
    *,
    fit: Fit | Path | str | None = None,
    structure: Structure | None = None,
    workers: int = 1,
    executor: Executor | None = None,
    say: Callable[[str], None] | None = None,
) -> Budget:
    """Predict the line-of-sight error and compare it with requirements.

    Parameters
    ----------
    source : Path or mapping
        BUDGET.toml, or the tables that it would hold (docs/budget.md): ``flight``, ``structure``, ``mode``,
        ``requirement``, ``error``. File names in tables are relative to the working folder.
    fit : Fit, Path or None
        Fit of the mechanism that flies, in place of the file that ``estimate`` names: a fit that holds its campaign, or
        a result folder.
    structure : Structure or None
        Structure that carries the mechanism, in place of the file that ``structure`` names.
    workers : int
        Number of threads.
    executor : concurrent.futures.Executor or None
        External executor, as `distributed.Client.get_executor()`; None uses threads.
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
    >>> [standing.level.value for standing in made.standings]  # doctest: +SKIP
    """
    if isinstance(source, Mapping):
        requested = budget_of_table(source, structure=structure, has_estimate=fit is not None)
    else:
        requested = read_budget_file(source, structure=structure, has_estimate=fit is not None)
    if not isinstance(fit, Fit):
        requested = requested if fit is None else replace(requested, estimate=estimate_path(fit))
        fit = read_fit(requested.estimate)
    with telling(say) as tell:
        return make_budget(requested, fit, workers, tell, executor=executor)
