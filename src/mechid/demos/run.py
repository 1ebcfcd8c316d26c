"""Public function that makes a synthetic bench and identifies it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from mechid.budgets.example import write_example
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.bench import TRUTH, refuse_measured_campaign, write_bench
from mechid.holding import hold_folder
from mechid.identification.computation.progress import Listener
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

    Nothing of it was measured, and its pages say so: the records are simulated from published values of a real
    mechanism, with noise, offset and drift; truth.json has these values.

    Parameters
    ----------
    out : Path
        Folder for the bench (campaign.toml, mechanism.toml, CSV files, budget.toml) and the results; made where it is
        missing.
    seed : int
        Of the bench's noise and of the search.
    workers, executor, listener, say
        As of `identify_into`.

    Returns
    -------
    Identified
        `fit`, `data` (every number of the report) and `files`.

    Raises
    ------
    UsageError
        The folder holds a campaign of measured records, cannot be written to, or another run holds it.

    Examples
    --------
    >>> import mechid
    >>> mechid.demo("mechid-demo").fit.grade  # doctest: +SKIP
    <Grade.A: 'A'>
    """
    with hold_folder(out):
        campaign = made_bench(Path(out), seed)
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


def made_bench(folder: Path, seed: int) -> Campaign:
    """Write the bench and a budget file of an assumed structure, and return the campaign with its records read."""
    refuse_measured_campaign(folder)
    campaign = load_campaign(write_bench(folder, seed))
    write_example(folder)
    return campaign
