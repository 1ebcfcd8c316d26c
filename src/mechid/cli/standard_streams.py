"""Standard output and error that may be closed, full, without a reader, or limited to few characters."""

from __future__ import annotations

import io
import os
import sys
from typing import Any, TextIO

from mechid.errors import UnwritableError

NOBODY_READS = 141
"""Exit code of a command whose reader has exited, as with ``| head``; equals that of other tools, ended by SIGPIPE."""
ANY_NAME = "backslashreplace"
"""Error handler for characters that a stream cannot encode, and for undecodable bytes of file names."""


class ReaderGoneError(Exception):
    """The reader of standard output has exited."""


class _Output(io.FileIO):
    """Standard output that raises its own errors, distinct from those of files, and only once."""

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
    """Standard error that ignores write errors."""

    def write(self, content: Any, /) -> int:
        """Write bytes; see `io.FileIO.write`."""
        try:
            return super().write(content)
        except OSError:
            return memoryview(content).nbytes


def prepare_streams() -> None:
    """Make standard streams accept any character, and redirect closed ones to the null device."""
    # The next opened file would otherwise get the number of a closed stream, and receive messages of libraries.
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
