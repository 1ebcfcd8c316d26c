"""Detection of outdated results, whose input files have changed.

Digests decide instead of times, so that copying a file or rewriting it unchanged does not make results stale.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.campaign.toml_file import read_toml
from mechid.errors import InputFileError
from mechid.identification.result.estimate_file import DIGEST, FILE
from mechid.indexes.kinds import CHECKS, FITS, LOOKS, SIMULATIONS
from mechid.indexes.result_reader import DAMAGE, FoundResult
from mechid.reading.whole import is_file
from mechid.records.formats import digest_of

AGAIN = {CHECKS: "check anew", SIMULATIONS: "simulate anew"}
"""Remedies for results whose own file names their campaign."""
GONE = ""
"""Digest of a file that is missing or unreadable."""


class Staleness:
    """Checker of results for outdated inputs; a file used by several results is read once.

    Parameters
    ----------
    results : iterable of FoundResult
        All results of an index.
    """

    def __init__(self, results: Iterable[FoundResult]) -> None:
        self.results = tuple(results)
        self._digests: dict[Path, str] = {}

    def cautions(self, found: FoundResult) -> tuple[str, ...]:
        """Return the reasons why a result is out of date; empty if it is not, or if unknown."""
        try:
            return tuple(self._cautions(found))
        # The verdict was readable, so the result is shown nevertheless.
        except DAMAGE:
            return ("its provenance is damaged, so that nothing tells whether it is out of date",)

    def campaign_of(self, found: FoundResult) -> Path | None:
        """Return the campaign file of a fit: in its folder, or else named in its journal."""
        # Imported here, since it takes a second to load.
        from mechid.identification.result.journal_file import identified_campaign

        beside = found.folder / CAMPAIGN_NAME
        try:
            return beside if is_file(beside) else identified_campaign(found.folder)
        except InputFileError:
            return None

    @cached_property
    def stale_fits(self) -> Mapping[str, bool]:
        """Whether fits are out of date, by the digest of their mechanism."""
        fits = (found for found in self.results if found.kind.heading == FITS and not found.is_damaged)
        return {_digest_of_fit(fit.content["provenance"]): bool(self.cautions(fit)) for fit in fits if _has_digest(fit)}

    def _cautions(self, found: FoundResult) -> Iterator[str]:
        if found.kind.heading == FITS:
            yield from self._of_records(found, self.campaign_of(found), "identify anew")
            yield from self._of_mechanism(found)
        elif found.kind.heading in AGAIN and found.content["provenance"]:
            campaign = Path(found.content["provenance"]["campaign"])
            yield from self._of_records(found, campaign, AGAIN[found.kind.heading])
        elif found.kind.heading == LOOKS:
            named = {Path(one["file"]): str(one["sha256"]) for one in found.content["records"]}
            # A relative path depends on the working directory of that run, which is unknown.
            known = {path: digest for path, digest in named.items() if path.is_absolute()}
            changed = [path.name for path, digest in known.items() if self._digest(path) not in (digest, GONE)]
            if changed:
                yield f"stale: {', '.join(changed)} changed since; look again"
        else:
            yield from self._of_fits(found.content)

    def _of_records(self, found: FoundResult, campaign: Path | None, remedy: str) -> Iterator[str]:
        if campaign is None or not is_file(campaign):
            return
        now = {path: self._digest(path) for path in _files(campaign)}
        then = found.content["provenance"]["inputs_sha256"]
        names = {path.name: digest for path, digest in now.items()}
        # A file that the campaign does not name any more cannot be compared and counts as unchanged.
        changed = [name for name, digest in then.items() if names.get(name, digest) not in (digest, GONE)]
        gone = [name for name in then if names.get(name) == GONE]
        if changed:
            yield f"stale: {', '.join(changed)} changed since; {remedy}"
        if gone:
            yield f"{', '.join(gone)}: not there any more"

    def _of_mechanism(self, found: FoundResult) -> Iterator[str]:
        """Yield a caution if the mechanism file of a fit is not the one written by identify."""
        provenance = found.content["provenance"]
        name, digest = str(provenance.get(FILE, "")), _digest_of_fit(provenance)
        if name and digest and self._digest(found.folder / name) != digest:
            yield f"{name}: is not as identify left it, so that nothing can be made of this fit"

    def _of_fits(self, content: Mapping[str, Any]) -> Iterator[str]:
        """Yield a caution if the fit of a result is missing or out of date."""
        provenance = content.get("provenance") or {}
        fits = provenance.get("fits") or [provenance.get("fit") or {}]
        digests = [digest for fit in fits if (digest := _digest_of_fit(fit))]
        if any(digest not in self.stale_fits for digest in digests):
            yield "stale: its fit is none of those below this folder; it was identified anew since, or lies elsewhere"
        elif any(self.stale_fits[digest] for digest in digests):
            yield "stale: its fit is"

    def _digest(self, path: Path) -> str:
        if path not in self._digests:
            try:
                self._digests[path] = digest_of(path) if is_file(path) else GONE
            except OSError:
                self._digests[path] = GONE
        return self._digests[path]


def _files(campaign: Path) -> Iterator[Path]:
    """Yield the campaign file, the mechanism file and the files of the records."""
    yield campaign
    try:
        content = read_toml(campaign)
    except (InputFileError, OSError):
        return
    records = content.get("record")
    entries = [one for one in records if isinstance(one, Mapping)] if isinstance(records, list) else []
    named = [content.get("mechanism"), *(one.get("file") for one in entries)]
    yield from (campaign.parent / name for name in named if isinstance(name, str) and name)


def _digest_of_fit(provenance: Mapping[str, Any]) -> str:
    return str(provenance.get(DIGEST) or "")


def _has_digest(fit: FoundResult) -> bool:
    provenance = fit.content.get("provenance")
    return isinstance(provenance, Mapping) and bool(_digest_of_fit(provenance))
