"""Standard output and error as other tools treat them: closed, full, read by nobody any more, or with few letters."""

from __future__ import annotations

import io
import os
import sys
from typing import Any, TextIO

from mechid.errors import UnwritableError

NOBODY_READS = 141
"""Exit code of a command whose reader has gone, as of ``| head``: that of the signal by which other tools end."""
ANY_NAME = "backslashreplace"
"""What becomes of letters that a stream does not have, and of bytes in a file's name that are no letters."""


class ReaderGoneError(Exception):
    """Whoever read standard output has gone."""


class _Output(io.FileIO):
    """Standard output, whose faults are told from those of files, once."""

    failed = False

    def write(self, content: Any, /) -> int:
        """Write bytes; see `io.FileIO.write`."""
        if self.failed:
            return memoryview(content).nbytes
        try:
            return super().write(content)
        except BrokenPipeError:
            self.failed = True
            raise ReaderGoneError from None
        except OSError as error:
            self.failed = True
            raise UnwritableError(f"standard output: cannot be written to ({error.strerror})") from error


class _Error(io.FileIO):
    """Standard error: what nobody can hear is no reason to end."""

    def write(self, content: Any, /) -> int:
        """Write bytes; see `io.FileIO.write`."""
        try:
            return super().write(content)
        except OSError:
            return memoryview(content).nbytes


def prepare_streams() -> None:
    """Let standard streams take any name, and give those that are closed a place where nothing is kept.

    Otherwise a result file that is opened next would be the one to which a library writes its messages.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
    sys.stdout = _text(_Output(1, "w", closefd=False), sys.stdout, by_line=os.isatty(1))
    sys.stderr = _text(_Error(2, "w", closefd=False), sys.stderr, by_line=True)


def _text(raw: io.FileIO, like: TextIO | None, *, by_line: bool) -> TextIO:
    return io.TextIOWrapper(
        io.BufferedWriter(raw), like.encoding if like else "utf-8", ANY_NAME, line_buffering=by_line
    )
