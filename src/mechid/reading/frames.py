"""Transfer of values through a pipe: a pickle, followed by the raw buffers of its arrays, without a copy."""

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
        The reading end of the pipe is closed.
    """
    buffers: list[pickle.PickleBuffer] = []
    body = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    parts = [memoryview(body), *(buffer.raw() for buffer in buffers)]
    sizes = (len(parts), *(part.nbytes for part in parts))
    # The sizes come first, so that the receiver can allocate every buffer before it reads.
    for part in (memoryview(b"".join(map(NUMBER.pack, sizes))), *parts):
        left = part
        # An unbuffered pipe may accept only a part of the bytes at a time.
        while left:
            left = left[pipe.write(left) :]


def receive(pipe: FileIO) -> Any:
    """Return the next value from a pipe, with writable arrays.

    Raises
    ------
    EOFError
        The pipe ends before or within the value.
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
