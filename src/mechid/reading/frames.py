"""Values through a pipe: pickled, the numbers of arrays behind it as they lie in memory, without a copy."""

from __future__ import annotations

import pickle
import struct
from io import FileIO
from typing import Any

NUMBER = struct.Struct("<Q")


def send(pipe: FileIO, value: Any) -> None:
    """Write a value to a pipe.

    Raises
    ------
    OSError
        Nobody reads it.
    """
    buffers: list[pickle.PickleBuffer] = []
    body = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    parts = [memoryview(body), *(buffer.raw() for buffer in buffers)]
    sizes = (len(parts), *(part.nbytes for part in parts))
    for part in (memoryview(b"".join(map(NUMBER.pack, sizes))), *parts):
        left = part
        while left:
            left = left[pipe.write(left) :]


def receive(pipe: FileIO) -> Any:
    """Return the next value of a pipe; its arrays can be written to.

    Raises
    ------
    EOFError
        The pipe ends before it, or within.
    """
    count = _number(pipe)
    sizes = [_number(pipe) for _ in range(count)]
    body, *buffers = [_read(pipe, size) for size in sizes]
    return pickle.loads(body, buffers=buffers)


def _number(pipe: FileIO) -> int:
    return int(NUMBER.unpack(_read(pipe, NUMBER.size))[0])


def _read(pipe: FileIO, size: int) -> bytearray:
    content = bytearray(size)
    left = memoryview(content)
    while left:
        done = pipe.readinto(left)
        if not done:
            raise EOFError
        left = left[done:]
    return content
