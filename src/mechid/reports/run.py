"""Public functions that identify a campaign, in memory or into a folder, and rewrite its report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from mechid.analysis import validate
from mechid.campaign import Campaign
from mechid.identification.computation.progress import Listener
from mechid.identification.computation.workforce import working_on
from mechid.identification.result.estimate_file import read_estimate, sign_provenance
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.identification.run import IdentifyRun
from mechid.identification.run import identify as identified
from mechid.ink.docx_file import refuse_without_docx
from mechid.ink.pens import Pens
from mechid.locks import hold_folder
from mechid.progress.listening import line_receiver, progress_listener
from mechid.reports.files import write_report
from mechid.reports.illustration import Illustration
from mechid.reports.into_folder import Audience, Identified, identify_into_folder, mechanism_name
from mechid.reports.numbers import report_data
from mechid.reports.results import estimated_text, read_truth, write_components, write_residual, write_results


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
        External executor for the work, as `distributed.Client.get_executor()`; None uses threads.
    listener : callable or None
        Called with each `Progress`; None shows a line in a notebook and nothing elsewhere.
    near : mapping of str to float or None
        Values by dotted name, in the file's units, so close to the optimum that their residuals are noise. Search and
        confirmation are then omitted. They have no effect if the campaign has stages.
    complete : bool
        Add the missing effects that the records support to the mechanism, and identify again. `completed` of the fit
        holds the steps; its `mechanism` and `parameters` are those of the completed mechanism.

    Returns
    -------
    Fit
        Returned also after a failure or an interruption, which its `outcome` and `grade` state. It holds the campaign,
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
    with progress_listener(listener) as tell, working_on(executor):
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
    docx: bool = False,
) -> Identified:
    """Identify as `identify`, and write the files of ``mechid identify`` into a folder: journal, results, report.

    Parameters
    ----------
    campaign, seed, workers, executor, listener, complete
        As of `identify`.
    out : Path
        Folder for the results, created if missing. All other commands can use it if the campaign was loaded from
        files.
    say : callable or None
        Called with single lines; None shows the latest one in a notebook and nothing elsewhere.
    resume : bool
        Whether to resume the last run in `out`.
    truth : mapping of str to float or None
        True values of simulated records by dotted name, in the file's units; the report then states the simulation.
    docx : bool
        Whether the test report is written too, as report.docx (extra ``office``).

    Returns
    -------
    Identified
        `fit`, `data` (every number of the report) and `files`.

    Raises
    ------
    FitError
        Nothing is free, or no record is to be estimated from.
    UsageError
        The folder cannot be written to, another run is using it, the run to be resumed had other inputs, or python-docx
        is not installed.
    WorkersError
        The executor's workers are lost, or cannot do the work.

    Examples
    --------
    >>> import mechid
    >>> done = mechid.identify_into(mechid.load_campaign("bench"), "fit")  # doctest: +SKIP
    """

    @contextmanager
    def follow_progress() -> Iterator[Listener]:
        with progress_listener(listener) as tell:
            yield tell

    if docx:
        refuse_without_docx()
    with hold_folder(out), line_receiver(say) as tell_line, working_on(executor):
        audience = Audience(followed=follow_progress, say=tell_line)
        run = IdentifyRun(seed=seed, workers=workers, complete=complete, resume=resume, truth=truth)
        return identify_into_folder(campaign, Path(out), audience, run, docx=docx)


def report(
    fit: Fit,
    out: Path | str,
    *,
    campaign: Campaign | None = None,
    synthetic: bool = False,
    truth: Mapping[str, float] | None = None,
    docx: bool = False,
) -> list[Path]:
    """Write the results and the report of a fit into a folder: estimate.json, report.html, figures and all else.

    Parameters
    ----------
    fit : Fit
    out : Path
        Made with its parents where it is missing; earlier files of the names are replaced. Where it holds the results
        of this very fit, as one of `load_fit`, these stay and the report alone is made anew.
    campaign : Campaign or None
        Of which it was identified, its records read; None takes the one that the fit holds.
    synthetic : bool
        Whether the records were simulated, which every page then says.
    truth : mapping of str to float or None
        True values by dotted name, in the file's units; given, the records count as simulated.
    docx : bool
        Whether the test report is written too, as report.docx (extra ``office``).

    Returns
    -------
    list of Path
        The files, and the folder of the figures.

    Raises
    ------
    UsageError
        The folder cannot be written to, the fit's campaign is not known, or python-docx is not installed.

    Examples
    --------
    >>> import mechid
    >>> mechid.report(mechid.load_fit("fit"), "again")  # doctest: +SKIP
    """
    if docx:
        refuse_without_docx()
    own, folder = campaign or fit.required_campaign, Path(out)
    with hold_folder(folder), Pens() as pens, Illustration(own, fit, folder, pens) as illustration:
        # Results of this very fit stay: the files hold one another's digests.
        again = _is_there(fit, folder)
        # True values are stored in report.json alone, which is replaced below.
        was, known = read_truth(folder) if again and truth is None else (False, truth)
        fit = replace(fit, synthetic=fit.synthetic or synthetic or was or truth is not None)
        validation = validate(own, fit, illustration.begin)
        name = mechanism_name(own, folder)
        fit = fit if again else sign_provenance(fit, name, estimated_text(fit))
        data = report_data(fit, known, validation=validation)
        files = [] if again else write_results(fit, data, folder, mechanism_name=name, validation=validation)
        files += write_report(data, own, fit, validation, folder, illustration, docx=docx)
        if again:
            files += [write_residual(fit, validation, folder), *write_components(fit, validation, folder)]
    # report.json is written with the results and again with the report.
    return list(dict.fromkeys(files))


def _is_there(fit: Fit, folder: Path) -> bool:
    """Tell whether a folder holds the results of this very fit, whose files are signed by one another."""
    path = folder / ESTIMATE_NAME
    return path.is_file() and read_estimate(path).get("provenance") == fit.provenance
