"""Files that are read whole: no devices, pipes or folders, and none that is longer than such a file can be."""

from __future__ import annotations

import errno
import stat
from pathlib import Path

MIB = 2**20
MOST_BYTES = 64 * MIB
"""Of a file that people write, tables of numbers included."""
MOST_BYTES_OF_RESULTS = 512 * MIB
"""Of a file that mechid writes."""
KINDS = (
    (stat.S_ISDIR, "it is a folder"),
    (stat.S_ISFIFO, "it is a pipe"),
    (stat.S_ISSOCK, "it is a socket"),
)


def is_file(path: Path) -> bool:
    """Whether a path leads to a file; a name that no file can have, as one that is too long, does not."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_folder(path: Path) -> bool:
    """Whether a path leads to a folder; a name that none can have does not."""
    try:
        return path.is_dir()
    except OSError:
        return False


def is_there(path: Path) -> bool:
    """Whether a path leads to anything; a name that nothing can have does not."""
    try:
        return path.exists()
    except OSError:
        return False


def refuse_special(path: Path) -> None:
    """Refuse what is no regular file: opening a pipe or a device may never end.

    Raises
    ------
    OSError
        It is none, or it is not there; `strerror` says what was found.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        found = next((words for is_kind, words in KINDS if is_kind(mode)), "it is a device")
        number = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
        raise OSError(number, f"{found}, no file", str(path))


def read_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """Return what a file holds.

    Raises
    ------
    OSError
        As `refuse_special`; it cannot be read, or it holds more than `most` bytes.
    """
    refuse_special(path)
    too_long = OSError(errno.EFBIG, f"it is longer than {most // MIB} MiB", str(path))
    if path.stat().st_size > most:
        raise too_long
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise too_long
    return content


def read_text(path: Path) -> str:
    """Return the UTF-8 text that a file of people's holds, line ends as Python has them.

    Raises
    ------
    OSError
        As `read_bytes`.
    UnicodeDecodeError
        It is no such text.
    """
    content = read_bytes(path).decode("utf-8-sig")
    return content.replace("\r\n", "\n").replace("\r", "\n")


def read_result(path: Path) -> str:
    """Return the UTF-8 text of a file that mechid has written; errors as of `read_text`."""
    return read_bytes(path, MOST_BYTES_OF_RESULTS).decode("utf-8")
