"""Identification into a folder: journal, results and report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mechid.analysis import RecordValidation, validate
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.mechanism_text import write_mechanism
from mechid.errors import UnwritableError
from mechid.fits.load import COMPLETED_NAME
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, Progress
from mechid.identification.output_error.digests import campaign_digests
from mechid.identification.result.estimate_file import sign_provenance
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.journal_file import FILE_NAME, StageLines
from mechid.identification.run import Companion, IdentifyRun, mark_unexamined, run_identification
from mechid.identification.uncertainty.visibility import refuse_unidentifiable
from mechid.ink.pens import Pens
from mechid.reports.illustration import Illustration
from mechid.reports.numbers import report_data
from mechid.reports.results import ESTIMATED, MECHANISM_NAME, REPORT_NAME, estimated_text, write_results

if TYPE_CHECKING:
    from mechid.identification.diagnosis.diagnosis import Diagnosis

ESTIMATED_NAME = "mechanism_estimated.toml"
"""File name of the estimated mechanism if the folder holds another `MECHANISM_NAME` that must remain."""
FIRST_LETTERS = 1000
"""Letters at the start of a mechanism file that are searched for the remark that it is estimated."""
DEFAULT_RUN = IdentifyRun()


@dataclass(frozen=True, kw_only=True)
class Audience:
    """Receivers of the progress and the messages of an identification.

    Parameters
    ----------
    followed : callable
        Returns a context manager for each search, which yields the listener to its progress.
    say : callable
        Called with single lines.
    """

    followed: Callable[[], AbstractContextManager[Listener]]
    say: Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Identified:
    """A fit, the data of its report (`report_data`), and the written files."""

    fit: Fit
    data: Mapping[str, Any]
    files: tuple[Path, ...]


def identify_into_folder(
    campaign: Campaign, folder: Path, audience: Audience, run: IdentifyRun = DEFAULT_RUN, *, docx: bool = False
) -> Identified:
    """Identify a campaign and write journal, results and report into a folder, also after a failure.

    The results are written as soon as the search has ended; later steps, which may fail or be interrupted, replace
    them. If the search is interrupted, they are the best values so far, without a report.

    Parameters
    ----------
    campaign : Campaign
    folder : Path
        Made with its parents where it is missing.
    audience : Audience
    run : IdentifyRun
    docx : bool
        Whether the test report is written too, as a Word document.

    Raises
    ------
    FitError
        Nothing is free, or no record is to be estimated from.
    UsageError
        The folder cannot be written to, or the run to be resumed had other inputs.
    KeyboardInterrupt
        The run was interrupted after the search; the estimate in the folder states that it was not examined.
    """
    with Pens() as pens, ExitStack() as entered:  # pens load beside the search, which leaves a core idle now and then

        def illustrate(fit: Fit) -> Illustration:
            return entered.enter_context(Illustration(fit.required_campaign, fit, folder, pens))

        into = _IntoFolder(folder, audience, run, illustrate)
        with into.told_where_the_estimate_is():
            # A campaign that no fit can be made of leaves no journal either.
            refuse_unidentifiable(campaign)
            into.open_journal(campaign)
            fit = run_identification(campaign, run, into)
            if fit.outcome is FitOutcome.INTERRUPTED:
                into.stages.finish(fit)
                return replace(into.written[-1], files=(*into.written[-1].files, folder / FILE_NAME))
            done = into.write(fit)
        into.stages.finish(fit)
        shown = _report(done, into.validation, folder, audience.say, into.illustration, docx=docx)
    return replace(done, files=(*done.files, folder / FILE_NAME, *into.diagnosis_files, *shown))


class _IntoFolder(Companion):
    """Companion of an identification that writes each result into a folder as soon as it is available."""

    stages: StageLines
    illustration: Illustration

    def __init__(
        self,
        folder: Path,
        audience: Audience,
        run: IdentifyRun,
        illustrated: Callable[[Fit], Illustration],
    ) -> None:
        super().__init__()
        self.folder, self.audience, self.run, self.illustrated = folder, audience, run, illustrated
        self.keep_early = self.keep
        self.written: list[Identified] = []
        self.diagnosis_files: list[Path] = []
        self.validation: Mapping[str, RecordValidation] = {}

    def open_journal(self, campaign: Campaign) -> None:
        """Open the journal of the folder, and report the number of steps that it already holds."""
        path, run = self.folder / FILE_NAME, self.run
        about = {"campaign": str(campaign.path.resolve()), "seed": run.seed, "mechid": version("mechid")}
        self.journal = Journal.open(path, identification_inputs(campaign, run.seed), resume=run.resume, **about)
        self.stages = StageLines(self.journal)
        if self.journal.notice:
            self.say(f"warning: {self.journal.notice}")
        if run.resume:
            self.say(f"{path}: {len(self.journal.known)} steps are there already")

    @contextmanager
    def progress(self) -> Iterator[Listener]:
        """Show the progress of the searches; that of the mechanism as written is also journalled."""
        is_completed = bool(self.diagnosis_files)
        with self.audience.followed() as listener:

            def tell(progress: Progress) -> None:
                listener(progress)
                if not is_completed:
                    self.stages.tell(progress)

            yield tell

    def keep(self, fit: Fit) -> None:
        """Write a fit, marked as not examined yet."""
        self.written.append(self.write(mark_unexamined(fit)))

    def complete(self, campaign: Campaign, found: Diagnosis) -> Campaign:
        """Write the diagnosis and its proposed mechanism, and return the campaign with that mechanism."""
        from mechid.diagnoses.document import PRESENTER, PROPOSED

        self.diagnosis_files = PRESENTER.write(found, PRESENTER.numbers(found), self.folder)
        if found.mechanism is None:
            return campaign
        path = self.folder / COMPLETED_NAME
        write_mechanism(found.mechanism, path, PROPOSED)
        self.diagnosis_files = [path, *self.diagnosis_files]
        in_files = campaign.path.is_file()
        return load_campaign(campaign.path, mechanism_file=path) if in_files else super().complete(campaign, found)

    def judge(self, fit: Fit) -> None:
        """Validate the records; their figures are started meanwhile."""
        self.illustration = self.illustrated(fit)
        self.validation = validate(fit.required_campaign, fit, self.illustration.begin)

    def say(self, line: str) -> None:
        """Pass a line to the audience."""
        self.audience.say(line)

    def write(self, fit: Fit) -> Identified:
        """Write the results of a fit, with the validation if there is one, and return them."""
        truth, validation = self.run.truth, self.validation or None
        name = mechanism_name(fit.required_campaign, self.folder)
        fit = replace(fit, synthetic=fit.synthetic or truth is not None)
        # The provenance holds the digest of the mechanism file, so its text is needed before any file is written.
        fit = sign_provenance(fit, name, estimated_text(fit))
        data = report_data(fit, truth, validation=validation)
        files = write_results(fit, data, self.folder, mechanism_name=name, validation=validation)
        return Identified(fit=fit, data=data, files=tuple(files))

    @contextmanager
    def told_where_the_estimate_is(self) -> Iterator[None]:
        """After an interruption that follows the search, report the location of the estimate and the next command."""
        try:
            yield
        except KeyboardInterrupt:
            if self.written:
                self.say(
                    f"the estimate is in {self.folder}, not examined any further; the same command with --resume goes "
                    f'on, "mechid report {self.folder}" makes its report'
                )
            raise


def mechanism_name(campaign: Campaign, folder: Path) -> str:
    """Return the file name of the estimated mechanism in a folder, which replaces no file written by a user.

    Such a file is the campaign's own, or any without the remark that mechid has estimated it.
    """
    place = folder / MECHANISM_NAME
    is_own = place.resolve() == campaign.mechanism_path.resolve()
    return ESTIMATED_NAME if is_own or _is_written_by_hand(place) else MECHANISM_NAME


def _is_written_by_hand(file: Path) -> bool:
    try:
        # A file in another encoding is a user's own; strict decoding would raise an error instead.
        with file.open(encoding="utf-8", errors="replace") as text:
            return ESTIMATED not in text.read(FIRST_LETTERS)
    except OSError:  # as where there is none
        return False


def identification_inputs(campaign: Campaign, seed: int) -> dict[str, str]:
    """Return the digests that identify the inputs of an identification in its journal."""
    return {**campaign_digests(campaign), "seed": str(seed)}


def _report(
    done: Identified,
    validation: Mapping[str, RecordValidation],
    folder: Path,
    say: Callable[[str], None],
    illustration: Illustration,
    *,
    docx: bool,
) -> list[Path]:
    """Write the report; if a figure or a text fails, only warn, since the estimate is already on disk."""
    say("making the report ...")
    try:
        from mechid.reports.files import write_report

        files = write_report(
            done.data, done.fit.required_campaign, done.fit, validation, folder, illustration, docx=docx
        )
        return [path for path in files if path.name != REPORT_NAME]
    except KeyboardInterrupt:
        say(f'the estimate is in {folder}; "mechid report {folder}" makes its report')
        raise
    except UnwritableError:
        raise
    except Exception as error:
        # Without a report no page shows the figures.
        illustration.give_up()
        what = " ".join(f"{type(error).__name__}: {error}".split())
        say(f'warning: no report was made ({what}); "mechid report {folder}" tries again')
        return []
