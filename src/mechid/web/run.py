"""Public function that serves the explorer of a campaign and its results."""

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
from mechid.progress.listening import line_receiver
from mechid.web import Estimate, Explorer, Source, estimate_of, read_diagnosed, read_estimated

GIVEN = "the fit given"
INTERRUPT_CHECK_S = 1.0
"""Interval in s of checks for Ctrl-C, which does not interrupt a wait on Windows."""


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
    """Serve a page for changing parameters and following fits, until Ctrl-C or "interrupt" in a notebook.

    The page is accessible from this machine only.

    Parameters
    ----------
    campaign : Campaign or Path
        Campaign, or its file or folder.
    fit : Fit, Path or None
        A fit of the campaign, or its result folder, whose fit may still be running. None takes the results next to the
        campaign file.
    diagnosis : Path or None
        Result folder of a diagnosis; the page gets a switch for each named effect.
    port : int
        Port of the page; 0 takes any free one.
    workers : int or None
        Threads of a fit; None takes one per core.
    browser : bool
        Whether to open the page in a browser.
    say : callable or None
        Called with the address of the page once it answers; None shows it in notebooks only.

    Raises
    ------
    InputFileError
        A campaign, mechanism or result file is missing or invalid, or belongs to another campaign.
    RecordError
        A record's file is missing or unusable.
    UsageError
        The port is in use.

    Examples
    --------
    >>> import mechid
    >>> mechid.explore("bench", fit="fit")  # doctest: +SKIP
    """
    source = load_source(campaign, fit=fit, diagnosis=diagnosis, workers=workers)
    with line_receiver(say) as tell:
        serve(source, port, browser=browser, ready=tell)


def load_source(
    campaign: Campaign | Path | str,
    *,
    fit: Fit | Path | str | None = None,
    diagnosis: Path | str | None = None,
    workers: int | None = None,
    needed: Callable[[Campaign], None] = lambda campaign: None,
) -> Source:
    """Load the data of the page; `needed` is called with each campaign before it is simulated."""
    folder = _result_folder(campaign, fit)
    loaded = _load_campaign(campaign, fit, folder)
    needed(loaded)
    estimate = _load_estimate(loaded, fit, folder)
    diagnosed = None
    if diagnosis is not None:
        loaded, diagnosed = read_diagnosed(Path(diagnosis), loaded, estimate)
        needed(loaded)
    elif estimate is not None and estimate.mechanism is not None:
        loaded = replace(loaded, mechanism=estimate.mechanism)
        needed(loaded)
    # A diagnosed fit has ended, so there is nothing to follow.
    followed = folder / JOURNAL_NAME if folder and not diagnosis else None
    return Source(loaded, estimate, workers, followed, diagnosed)


def _result_folder(campaign: Campaign | Path | str, fit: Fit | Path | str | None) -> Path | None:
    """Return the result folder, which may be empty; None if fit or campaign are in memory."""
    # A given folder may belong to a running fit, which is then followed.
    if isinstance(fit, Path | str):
        return Path(fit)
    if fit is not None or isinstance(campaign, Campaign):
        return None
    place = Path(campaign)
    return place if place.is_dir() else place.parent


def _load_campaign(campaign: Campaign | Path | str, fit: Fit | Path | str | None, folder: Path | None) -> Campaign:
    """Load the campaign with its records, and with the mechanism completed by its fit."""
    there = folder is not None and (folder / ESTIMATE_NAME).is_file()
    completed = completed_file(folder) if folder is not None and there else None
    if not isinstance(campaign, Campaign):
        campaign = load_campaign(campaign, mechanism_file=completed)
    elif completed is not None:
        campaign = replace(campaign, mechanism=load_mechanism(completed), mechanism_path=completed)
    return campaign_of_fit(campaign, fit) if isinstance(fit, Fit) else campaign


def _load_estimate(campaign: Campaign, fit: Fit | Path | str | None, folder: Path | None) -> Estimate | None:
    """Load the estimate; None if there is none yet."""
    if isinstance(fit, Fit):
        return estimate_of(fit, campaign, GIVEN)
    if folder is None:
        return None
    path, at_work = folder / ESTIMATE_NAME, (folder / JOURNAL_NAME).is_file()
    # A folder given explicitly must have an estimate, unless its fit may still be running.
    is_required = fit is not None and not at_work
    return read_estimated(path, campaign) if path.is_file() or is_required else None


def serve(source: Source, port: int, *, browser: bool, ready: Callable[[str], None]) -> None:
    """Serve the page until Ctrl-C; in a separate thread if an event loop is running, as in a notebook."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        with _own_loop():
            Explorer(source, port).serve(opens_browser=browser, ready=ready)
    else:
        _serve_beside(source, port, browser=browser, ready=ready)


@contextmanager
def _own_loop() -> Iterator[None]:
    """Create an event loop for this thread, which has none by default from Python 3.12."""
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
                # The future raises it in the calling thread, for instance for a port in use.
                made.set_exception(error)
            else:
                made.set_result(explorer)
                explorer.serve(opens_browser=browser, ready=ready)

    thread = Thread(target=work, name="explorer", daemon=True)
    thread.start()
    explorer = made.result()
    try:
        while thread.is_alive():
            thread.join(INTERRUPT_CHECK_S)
    except KeyboardInterrupt:
        explorer.stop()
        thread.join()
