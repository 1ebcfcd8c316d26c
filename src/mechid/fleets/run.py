"""Public function for identifying many campaigns and evaluating their parameters together."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from mechid.fleets.fleet import Fleet, make_fleet
from mechid.fleets.fleet_file import read_members
from mechid.identification.computation.workforce import working_on
from mechid.progress.listening import telling


def fleet(
    *sources: Path | str,
    out: Path | str,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    complete: bool = False,
    say: Callable[[str], None] | None = None,
) -> Fleet:
    """Identify many campaigns and evaluate their parameters together.

    Parameters
    ----------
    *sources : Path
        Campaign folders or files, result folders of `mechid identify`, and at most one fleet file or its folder.
    out : Path
        Folder for results. The result of each campaign is written to ``out/units/<label>``; a finished fit of the
        unchanged campaign there is reused.
    seed : int
        Seed of each search.
    workers : int or None
        Number of threads of each identification; None takes one per core.
    executor : Executor or None
        External executor, whose workers identify one campaign each and must see the same folders. None identifies the
        campaigns one after the other in this process.
    complete : bool
        Add the effects to each mechanism that its records show to be missing.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.

    Returns
    -------
    Fleet
        Also if some campaigns failed; `failed` names them.

    Raises
    ------
    UsageError
        Nothing is given, or `out` cannot be written to.
    InputFileError
        A folder is missing, or the fleet file is wrong.
    KeyboardInterrupt
        The run was interrupted; the next call resumes it.

    Examples
    --------
    >>> import mechid
    >>> made = mechid.fleet("FM1", "FM2", "FM3", out="fleet")  # doctest: +SKIP
    """
    with telling(say) as tell, working_on(executor):
        return make_fleet(read_members(sources), Path(out), seed=seed, workers=workers, complete=complete, say=tell)
