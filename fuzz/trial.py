"""One input tried: accepted, refused, or a finding."""

import json
import re
import shutil
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzz.draw import Draw

ACCEPTED, REFUSED, FINDING = "accepted", "refused", "finding"
LIMIT_S = 10.0
"""CPU time of one input."""
ATTEMPTS = 20
HOW = "how.json"
"""What was written, beside the files of an input that is kept."""


class Misread(Exception):  # noqa: N818
    """mechid read something else than was written."""


class _Late(BaseException):
    """The time of an input is over."""


@dataclass(frozen=True)
class Kind:
    """A kind of input.

    Parameters
    ----------
    name : str
    build : callable
        Writes an input into a folder; returns what it wrote, as JSON holds it.
    read : callable
        Has mechid read it, and compares with what was written: `Misread` where that is something else.
    codes : tuple of int
        Exit codes with which such an input may be refused.
    weight : int
        Share of the inputs.
    """

    name: str
    build: Callable[[Draw, Path], dict[str, Any]]
    read: Callable[[Path, dict[str, Any]], None]
    codes: tuple[int, ...] = (3,)
    weight: int = 2


@dataclass(frozen=True)
class Outcome:
    """What became of an input; `where` tells findings of one cause from others."""

    kind: str
    what: str
    words: str = ""
    where: str = ""


def tried(kind: Kind, number: int, folder: Path) -> Outcome:
    """Build the input of a number in an empty folder, and have it read."""
    try:
        written = _built(kind, number, folder)
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        words = f"the builder failed: {type(error).__name__}: {error} ({last.filename}:{last.lineno})"
        return Outcome(kind.name, FINDING, words[:600], f"{kind.name} builder {type(error).__name__} {last.lineno}")
    (folder / HOW).write_text(json.dumps(written))
    return read_again(kind, folder)


def _built(kind: Kind, number: int, folder: Path) -> dict[str, Any]:
    """Return what was written; a library that does not write what was drawn is asked for something else."""
    for again in range(ATTEMPTS):
        try:
            with _quiet():
                return kind.build(Draw(kind.name, number + again * 10**9), folder)
        except Exception:
            if again == ATTEMPTS - 1:
                raise
            for path in folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    raise NotImplementedError


def read_again(kind: Kind, folder: Path) -> Outcome:
    """Have an input read whose files are there."""
    from mechid.errors import MechidError

    written = json.loads((folder / HOW).read_text())
    signal.signal(signal.SIGPROF, _end)
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    try:
        with _quiet():
            kind.read(folder, written)
    except MechidError as error:
        if error.exit_code in kind.codes:
            return Outcome(kind.name, f"{REFUSED} {error.exit_code}", str(error))
        return _finding(kind, error)
    except _Late as error:
        return _finding(kind, error, f"no end within {LIMIT_S:.0f} s of CPU time")
    except Exception as error:
        return _finding(kind, error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return Outcome(kind.name, ACCEPTED)


def _finding(kind: Kind, error: BaseException, words: str = "") -> Outcome:
    """Return the outcome, with the innermost line of mechid that it came from."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/mechid/" in frame.filename]
    at = f"{frames[-1].filename.rpartition('/mechid/')[2]}:{frames[-1].name}" if frames else ""
    words = words or f"{type(error).__name__}: {error}"
    shape = re.sub(r"[\d.+-]+(e[+-]?\d+)?|\"[^\"]*\"|'[^']*'", "_", words)[:90]
    if isinstance(error, Misread):
        at, shape = "misread", str(error).partition(":")[0]
    return Outcome(kind.name, FINDING, words[:600], f"{kind.name} {at} {shape}")


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave warnings of NumPy and others alone."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _end(number: int, frame: object) -> None:
    raise _Late
