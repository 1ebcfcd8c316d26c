"""From a campaign to a fit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path

from mechid.campaign import Campaign
from mechid.holding import held
from mechid.identification.computation.progress import Listener
from mechid.identification.computation.workforce import working_on
from mechid.identification.result.fit import Fit
from mechid.identification.run import IdentifyRun
from mechid.identification.run import identify as identified
from mechid.progress.listening import listening, telling
from mechid.reports.identified import Audience, Identified, identify_into_folder


def identify(
    campaign: Campaign,
    *,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
    near: Mapping[str, float] | None = None,
    complete: bool = False,
) -> Fit:
    """Identify the free parameters of a campaign's mechanism from its records.

    Parameters
    ----------
    campaign : Campaign
    seed : int
        Of the search; equal seeds give equal results.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        Whose workers do the work, as `distributed.Client.get_executor()`; None leaves it to threads.
    listener : callable or None
        Called with each `Progress`; None shows a line in a notebook and nothing elsewhere.
    near : mapping of str to float or None
        Values by dotted name, in the file's units, that are close to the optimum, so that what they leave of the
        records is noise. Search and confirmation are left out; they have no effect where the campaign has stages.
    complete : bool
        Add to the mechanism what its records say it lacks, and identify again; `completed` of the fit has the steps,
        and its `mechanism` and `parameters` are those of the completed one.

    Returns
    -------
    Fit
        Also where the fit did not succeed or was interrupted: its `outcome` and `grade` say so. It holds the campaign,
        for `plot` and `write`.

    Raises
    ------
    FitError
        Nothing is free, or no record is to be estimated from.
    WorkersError
        The executor's workers are lost, or cannot do the work.

    Examples
    --------
    >>> import mechid
    >>> fit = mechid.identify(mechid.load_campaign("bench"))  # doctest: +SKIP
    >>> fit.parameters["gear.stiffness"].value  # doctest: +SKIP
    913.5
    """
    run = IdentifyRun(seed=seed, workers=workers, near=near, complete=complete)
    with listening(listener) as tell, working_on(executor):
        return identified(campaign, run, tell)


def identify_into(
    campaign: Campaign,
    out: Path | str,
    *,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
    say: Callable[[str], None] | None = None,
    resume: bool = False,
    complete: bool = False,
    truth: Mapping[str, float] | None = None,
) -> Identified:
    """Identify as `identify` does, and leave in a folder what ``mechid identify`` leaves: journal, results, report.

    Parameters
    ----------
    campaign, seed, workers, executor, listener, complete
        As of `identify`.
    out : Path
        Folder for the results; made where missing. Every other command goes on from there, if the campaign is one of
        files.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.
    resume : bool
        Go on where the last run in `out` was stopped.
    truth : mapping of str to float or None
        True values by dotted name, in the file's units: of records that were simulated, which the report then says.

    Returns
    -------
    Identified
        `fit`, `data` (every number of the report) and `files`.

    Raises
    ------
    FitError
        Nothing is free, or no record is to be estimated from.
    UsageError
        The folder cannot be written to, another run holds it, or the run to be resumed had other inputs.
    WorkersError
        The executor's workers are lost, or cannot do the work.

    Examples
    --------
    >>> import mechid
    >>> done = mechid.identify_into(mechid.load_campaign("bench"), "fit")  # doctest: +SKIP
    """

    @contextmanager
    def followed() -> Iterator[Listener]:
        with listening(listener) as tell:
            yield tell

    with held(out), telling(say) as tell_line, working_on(executor):
        audience = Audience(followed=followed, say=tell_line)
        run = IdentifyRun(seed=seed, workers=workers, complete=complete, resume=resume, truth=truth)
        return identify_into_folder(campaign, Path(out), audience, run)
