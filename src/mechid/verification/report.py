"""Content of a test report besides the document of its result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from mechid.ink.data import Data
from mechid.ink.document import Document, Part

DIGEST_SHOWN = 16
"""Digits of a digest in the verification table; the files are listed with all 64."""


@dataclass(frozen=True, kw_only=True)
class Verified:
    """Row of the verification table, in words.

    Attributes
    ----------
    requirement : str
    method : str
        Verification method: test, analysis, or both.
    value, limit, margin : str
        With their units.
    verdict : str
    evidence : str
        File that the verdict rests on, with its digest.
    """

    requirement: str
    method: str
    value: str
    verdict: str
    limit: str = ""
    margin: str = ""
    evidence: str = ""


@dataclass(frozen=True, kw_only=True)
class VerificationReport:
    """Test report.

    Attributes
    ----------
    title : str
    document : Document
        Of the result; its first verdict is that of the report.
    verified : sequence of Verified
    meaning : str
        How the verdicts are to be read.
    test : mapping
        Statements on the test, as `DeclaredTest.to_dict` returns them; empty if none are known.
    set_up, instruments, noise, conditions : sequence of parts
        What the result itself says of them.
    runs : sequence of mapping
        Records with ``name``, ``use``, ``file``, ``sha256``, ``command``, ``started``, ``duration_s``,
        ``sample_rate_hz``; None or empty where not known.
    deviations : sequence of str
        Departures that the evaluation found.
    inputs : mapping of str to str
        SHA-256 of the files that were read, by name; those of the records need not be among them.
    versions : mapping of str to str
        Of the programs that made the result.
    files : mapping of str to str
        SHA-256 of the files of the result.
    """

    title: str
    document: Document
    verified: Sequence[Verified]
    meaning: str
    test: Mapping[str, Any] = field(default_factory=dict)
    set_up: Sequence[Part] = ()
    instruments: Sequence[Part] = ()
    noise: Sequence[Part] = ()
    conditions: Sequence[Part] = ()
    runs: Sequence[Data] = ()
    deviations: Sequence[str] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


def evidence_words(name: str, digest: str) -> str:
    """Return the name of a file with the beginning of its digest.

    Examples
    --------
    >>> evidence_words("run.csv", 16 * "0123")
    'run.csv, sha256 0123012301230123…'
    """
    return f"{name}, sha256 {digest[:DIGEST_SHOWN]}…" if digest else name
