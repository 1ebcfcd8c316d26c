"""Reading of complete files: regular files only, up to a maximum size."""

from __future__ import annotations

import errno
import stat
from pathlib import Path

MIB = 2**20
MAX_BYTES = 64 * MIB
"""Maximum size of user-written files, including tables of numbers."""
MAX_RESULT_BYTES = 512 * MIB
"""Maximum size of files written by mechid."""
KINDS = (
    (stat.S_ISDIR, "it is a folder"),
    (stat.S_ISFIFO, "it is a pipe"),
    (stat.S_ISSOCK, "it is a socket"),
)


def is_file(path: Path) -> bool:
    """Return whether a path is a file; False for an invalid name, such as one that is too long."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_folder(path: Path) -> bool:
    """Return whether a path is a folder; False for an invalid name."""
    try:
        return path.is_dir()
    except OSError:
        return False


def is_there(path: Path) -> bool:
    """Return whether a path exists; False for an invalid name."""
    try:
        return path.exists()
    except OSError:
        return False


def refuse_special(path: Path) -> None:
    """Raise an error unless a path is a regular file.

    Raises
    ------
    OSError
        The path does not exist or is not a regular file; `strerror` names the kind of file found.
    """
    # The check precedes opening because opening a pipe or a device may block forever.
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        found = next((words for is_kind, words in KINDS if is_kind(mode)), "it is a device")
        number = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
        raise OSError(number, f"{found}, not a file", str(path))


def read_bytes(path: Path, most: int = MAX_BYTES) -> bytes:
    """Return the content of a file.

    Raises
    ------
    OSError
        As for `refuse_special`; or the file cannot be read, or is larger than `most` bytes.
    """
    refuse_special(path)
    too_long = OSError(errno.EFBIG, f"it is larger than {most // MIB} MiB", str(path))
    if path.stat().st_size > most:
        raise too_long
    with path.open("rb") as file:
        # The file may grow after its size was taken: one byte more than allowed shows that it did.
        content = file.read(most + 1)
    if len(content) > most:
        raise too_long
    return content


def read_text(path: Path) -> str:
    r"""Return the text of a user-written UTF-8 file, with line ends converted to ``\n``.

    Raises
    ------
    OSError
        As for `read_bytes`.
    UnicodeDecodeError
        The content is not UTF-8.
    """
    content = read_bytes(path).decode("utf-8-sig")
    return content.replace("\r\n", "\n").replace("\r", "\n")


def read_result(path: Path) -> str:
    """Return the UTF-8 text of a file written by mechid; errors as for `read_text`."""
    return read_bytes(path, MAX_RESULT_BYTES).decode("utf-8")
