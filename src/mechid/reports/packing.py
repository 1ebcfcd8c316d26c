"""Arrays as short text in a page: whole numbers or 32-bit floats, bytes of one rank together, deflated, base64.

The page's script undoes it in `unpacked`; `unpack` is its twin here. Whole numbers are zigzag-coded (0, -1, 1,
-2, ... become 0, 1, 2, 3, ...), so that small ones have empty upper bytes, which deflate to nothing.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import blocks

Packed: TypeAlias = dict[str, Any]
"""``kind`` ("int" or "float"), ``size``, ``data``."""
WORD = 4
"""Bytes a number."""
LEVEL = 6
"""Of zlib; 9 is 2 % smaller and takes three times as long."""


def pack_integers(values: IntArray) -> Packed:
    """Return whole numbers, (n,), within 31 bits, as text.

    Examples
    --------
    >>> unpack(pack_integers(np.array([3, -2, 0, 70000]))).tolist()
    [3.0, -2.0, 0.0, 70000.0]
    """
    return pack_integer_blocks(values.size, [values])


def pack_integer_blocks(size: int, parts: Iterable[IntArray]) -> Packed:
    """Return whole numbers, `size` of them, that come block by block, as text."""
    # Little-endian on every platform: the page's script takes the first plane as the lowest bytes.
    words, done = np.empty(size, dtype="<u4"), 0
    for part in parts:
        # The arithmetic shift by 63 gives 0 or -1, so that the bits of negative numbers are inverted.
        words[done : done + part.size] = ((part << 1) ^ (part >> 63)).astype("<u4")
        done += part.size
    return _pack("int", words)


def pack_floats(values: FloatArray) -> Packed:
    """Return numbers, (n,), as text, each rounded to 24 bits.

    Examples
    --------
    >>> unpack(pack_floats(np.array([0.5, -2.0]))).tolist()
    [0.5, -2.0]
    """
    return _pack("float", values.astype("<f4"))


def unpack(packed: Packed) -> FloatArray:
    """Return the numbers, (n,)."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), dtype=np.uint8)
    words = np.ascontiguousarray(planes.reshape(WORD, packed["size"]).T)
    if packed["kind"] == "float":
        return words.view("<f4").ravel().astype(np.float64)
    zigzag = words.view("<u4").ravel().astype(np.int64)
    return ((zigzag >> 1) ^ -(zigzag & 1)).astype(np.float64)


def pack_text(text: str) -> str:
    """Return a text deflated, in base64."""
    # The slowest level pays off: the only text is BokehJS, which is packed once and then cached.
    return base64.b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")


def _pack(kind: str, words: NDArray[Any]) -> Packed:
    # Bytes of one rank together: the upper bytes of small numbers are runs of zeros.
    planes = np.ascontiguousarray(words).view(np.uint8).reshape(words.size, WORD).T
    deflate = zlib.compressobj(LEVEL)
    # A plane is a strided view, of which each block is copied by itself.
    parts = [deflate.compress(plane[part].tobytes()) for plane in planes for part in blocks(words.size)]
    data = base64.b64encode(b"".join((*parts, deflate.flush()))).decode("ascii")
    return {"kind": kind, "size": int(words.size), "data": data}
