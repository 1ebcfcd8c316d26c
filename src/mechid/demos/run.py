"""Public function that makes a synthetic bench and identifies it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from mechid.budgets.example import write_example
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.bench import TRUTH, refuse_measured_campaign, write_bench
from mechid.identification.computation.progress import Listener
from mechid.locks import hold_folder
from mechid.reports.into_folder import Identified
from mechid.reports.run import identify_into


def demo(
    out: Path | str = "mechid-demo",
    *,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
    say: Callable[[str], None] | None = None,
) -> Identified:
    """Make a synthetic bench in a folder, and identify it from catalogue values that are wrong by factors.

    The records are simulated from published values of a real mechanism, with noise, offset and drift; truth.json holds
    these values. All pages state that no data was measured.

    Parameters
    ----------
    out : Path
        Folder for the bench (campaign.toml, mechanism.toml, CSV files, budget.toml) and the results; created if
        missing.
    seed : int
        Seed of the noise and of the search.
    workers, executor, listener, say
        As for `identify_into`.

    Returns
    -------
    Identified
        `fit`, `data` (every number of the report) and `files`.

    Raises
    ------
    UsageError
        The folder contains a campaign of measured records, is not writable, or is in use by another run.

    Examples
    --------
    >>> import mechid
    >>> mechid.demo("mechid-demo").fit.grade  # doctest: +SKIP
    <Grade.A: 'A'>
    """
    with hold_folder(out):
        campaign = make_bench(Path(out), seed)
        return identify_into(
            campaign,
            out,
            seed=seed,
            workers=workers,
            executor=executor,
            listener=listener,
            say=say,
            truth=TRUTH,
        )


def make_bench(folder: Path, seed: int) -> Campaign:
    """Write the bench and a budget file with an assumed structure; return the loaded campaign."""
    refuse_measured_campaign(folder)
    campaign = load_campaign(write_bench(folder, seed))
    write_example(folder)
    return campaign
