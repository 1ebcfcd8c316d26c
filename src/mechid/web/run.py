"""Public function that serves the explorer of a campaign and what has been found of it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Thread

from mechid.campaign import Campaign, load_campaign, load_mechanism
from mechid.fits.load import campaign_of_fit, completed_file
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.identification.result.journal_file import FILE_NAME as JOURNAL_NAME
from mechid.progress.listening import telling
from mechid.web import Estimate, Explorer, Source, estimate_of, read_diagnosed, read_estimated

GIVEN = "the fit given"
OFTEN_S = 1.0
"""Between two looks for Ctrl-C, which Windows does not let break a wait."""


def explore(
    campaign: Campaign | Path | str,
    *,
    fit: Fit | Path | str | None = None,
    diagnosis: Path | str | None = None,
    port: int = 0,
    workers: int | None = None,
    browser: bool = True,
    say: Callable[[str], None] | None = None,
) -> None:
    """Serve a page on which parameters are turned and fits watched; it ends with Ctrl-C, or "interrupt" in a notebook.

    The page is for this machine alone.

    Parameters
    ----------
    campaign : Campaign or Path
        A campaign file or its folder is read.
    fit : Fit, Path or None
        A fit of the campaign, or the result folder of one, which may still be at work. None takes what lies beside the
        campaign file.
    diagnosis : Path or None
        Result folder of a diagnosis: the page has a switch for each effect that it names.
    port : int
        Of the page; 0 takes any that is free.
    workers : int or None
        Threads of a fit; None takes one per core.
    browser : bool
        Open the page in a browser.
    say : callable or None
        Called with the page's address once it answers; None shows it in a notebook and nowhere else.

    Raises
    ------
    InputFileError
        A campaign, mechanism or result file is missing or wrong, or is of another campaign.
    RecordError
        A record's file is missing or cannot be used.
    UsageError
        The port is taken.

    Examples
    --------
    >>> import mechid
    >>> mechid.explore("bench", fit="fit")  # doctest: +SKIP
    """
    source = explored(campaign, fit=fit, diagnosis=diagnosis, workers=workers)
    with telling(say) as tell:
        serve(source, port, browser=browser, ready=tell)


def explored(
    campaign: Campaign | Path | str,
    *,
    fit: Fit | Path | str | None = None,
    diagnosis: Path | str | None = None,
    workers: int | None = None,
    needed: Callable[[Campaign], None] = lambda campaign: None,
) -> Source:
    """Return what the page begins from; `needed` is called with each campaign before it is simulated."""
    folder = _results(campaign, fit)
    loaded = _loaded(campaign, fit, folder)
    needed(loaded)
    estimate = _estimated(loaded, fit, folder)
    diagnosed = None
    if diagnosis is not None:
        loaded, diagnosed = read_diagnosed(Path(diagnosis), loaded, estimate)
        needed(loaded)
    elif estimate is not None and estimate.mechanism is not None:
        loaded = replace(loaded, mechanism=estimate.mechanism)
        needed(loaded)
    followed = folder / JOURNAL_NAME if folder and not diagnosis else None  # the fit that was diagnosed has ended
    return Source(loaded, estimate, workers, followed, diagnosed)


def _results(campaign: Campaign | Path | str, fit: Fit | Path | str | None) -> Path | None:
    """Return the folder of results, which may be empty; None where the fit is a value, or nothing is in files."""
    if isinstance(fit, Path | str):
        return Path(fit)
    if fit is not None or isinstance(campaign, Campaign):
        return None
    place = Path(campaign)
    return place if place.is_dir() else place.parent


def _loaded(campaign: Campaign | Path | str, fit: Fit | Path | str | None, folder: Path | None) -> Campaign:
    """Return the campaign with its records read, and with the mechanism that its fit was completed to."""
    there = folder is not None and (folder / ESTIMATE_NAME).is_file()
    completed = completed_file(folder) if folder is not None and there else None
    if not isinstance(campaign, Campaign):
        campaign = load_campaign(campaign, mechanism_file=completed)
    elif completed is not None:
        campaign = replace(campaign, mechanism=load_mechanism(completed), mechanism_path=completed)
    return campaign_of_fit(campaign, fit) if isinstance(fit, Fit) else campaign


def _estimated(campaign: Campaign, fit: Fit | Path | str | None, folder: Path | None) -> Estimate | None:
    """Return what the fit says; None where there is none, or none yet."""
    if isinstance(fit, Fit):
        return estimate_of(fit, campaign, GIVEN)
    if folder is None:
        return None
    path, at_work = folder / ESTIMATE_NAME, (folder / JOURNAL_NAME).is_file()
    is_asked_for = fit is not None and not at_work
    return read_estimated(path, campaign) if path.is_file() or is_asked_for else None


def serve(source: Source, port: int, *, browser: bool, ready: Callable[[str], None]) -> None:
    """Serve the page until Ctrl-C; where an event loop is running already, as in a notebook, in a thread of its own."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        with _own_loop():
            Explorer(source, port).serve(opens_browser=browser, ready=ready)
    else:
        _serve_beside(source, port, browser=browser, ready=ready)


@contextmanager
def _own_loop() -> Iterator[None]:
    """Give this thread an event loop: from Python 3.12 on a thread has none before somebody makes one."""
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    try:
        yield
    finally:
        asyncio.set_event_loop(None)
        loop.close()


def _serve_beside(source: Source, port: int, *, browser: bool, ready: Callable[[str], None]) -> None:
    made: Future[Explorer] = Future()

    def work() -> None:
        with _own_loop():
            try:
                explorer = Explorer(source, port)
            except Exception as error:
                made.set_exception(error)
            else:
                made.set_result(explorer)
                explorer.serve(opens_browser=browser, ready=ready)

    thread = Thread(target=work, name="explorer", daemon=True)
    thread.start()
    explorer = made.result()
    try:
        while thread.is_alive():
            thread.join(OFTEN_S)
    except KeyboardInterrupt:
        explorer.stop()
        thread.join()
