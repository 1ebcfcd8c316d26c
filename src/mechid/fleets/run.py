"""Public function that identifies many campaigns and evaluates their parameters together."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from mechid.fleets.fleet import Fleet, make_fleet
from mechid.fleets.fleet_file import read_members
from mechid.identification.computation.workforce import working_on
from mechid.progress.listening import line_receiver


def fleet(
    *sources: Path | str,
    out: Path | str,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    complete: bool = False,
    say: Callable[[str], None] | None = None,
) -> Fleet:
    """Identify many campaigns, and say what their parameters say together.

    Parameters
    ----------
    *sources : Path
        Campaign folders or files, result folders of `mechid identify`, and at most one fleet file or its folder.
    out : Path
        The results of each campaign go to ``out/units/<label>``; a finished fit that lies there, of the campaign as it
        is now, is taken up.
    seed : int
        Of each search.
    workers : int or None
        Threads of each identification; None takes one per core.
    executor : Executor or None
        Whose workers identify the campaigns, each one after the other; they have to see the same folders. None: this
        process, one campaign after the other.
    complete : bool
        Add to each mechanism what its records say it lacks.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.

    Returns
    -------
    Fleet
        Also where some campaigns failed; `failed` names them.

    Raises
    ------
    UsageError
        Nothing is given, or `out` cannot be written to.
    InputFileError
        A folder is missing, or the fleet file is wrong.
    KeyboardInterrupt
        Interrupted; called again, it goes on from there.

    Examples
    --------
    >>> import mechid
    >>> made = mechid.fleet("FM1", "FM2", "FM3", out="fleet")  # doctest: +SKIP
    """
    with line_receiver(say) as tell, working_on(executor):
        return make_fleet(read_members(sources), Path(out), seed=seed, workers=workers, complete=complete, say=tell)
