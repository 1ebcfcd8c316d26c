"""Files that are read whole. Truth: what was written; a device, a pipe and an endless file are answered at once."""

import os
import socket

import pytest

from mechid.reading import whole
from mechid.reading.whole import read_bytes, read_result, read_text


def test_a_file_is_read(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\r\nb = 2\rc = 3\n")
    assert read_text(path) == "a = 1\nb = 2\nc = 3\n"
    assert read_result(path) == "\ufeffa = 1\r\nb = 2\rc = 3\n"


def test_it_may_be_as_long_as_the_limit(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"x" * 1000)
    assert len(read_bytes(path, 1000)) == 1000
    with pytest.raises(OSError, match="it is larger than"):
        read_bytes(path, 999)


def test_a_file_with_holes_is_not_read_into_memory(tmp_path):
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(OSError, match="it is larger than 64 MiB"):
        read_bytes(path)
    with pytest.raises(OSError, match="it is larger than 512 MiB"):
        read_bytes(path, whole.MAX_RESULT_BYTES)


@pytest.mark.parametrize("what", ["a folder", "a pipe", "a socket", "a device"])
def test_what_is_no_file_is_not_opened(what, tmp_path):
    path = tmp_path / "a.toml"
    if what == "a folder":
        path.mkdir()
    elif what == "a pipe":
        os.mkfifo(path)
    elif what == "a socket":
        with socket.socket(socket.AF_UNIX) as opened:
            opened.bind(str(path))
    else:
        path.symlink_to("/dev/zero")
    with pytest.raises(OSError, match=f"it is {what}, not a file"):
        read_bytes(path)
