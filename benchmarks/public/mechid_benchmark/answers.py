"""Packed answers: the true values and the emission of the held-out runs, so that a glance into a file gives nothing.

An entrant scores a submission on his own machine, so the answers are here. They are compressed, not secret: whoever
unpacks them competes with himself.
"""

import base64
import json
import zlib
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("answers.txt")
WIDTH = 100


def read_answers(path: Path = FILE) -> dict[str, Any]:
    """Return ``{campaign: {"parameters": {name: value}, "emission": {run: {"rms_Nm", "lines_Nm"}}}}``."""
    return json.loads(zlib.decompress(base64.b64decode(path.read_text(encoding="ascii"))))


def write_answers(answers: dict[str, Any], path: Path = FILE) -> None:
    """Write the packed answers."""
    packed = base64.b64encode(zlib.compress(json.dumps(answers, sort_keys=True).encode(), 9)).decode("ascii")
    lines = [packed[first : first + WIDTH] for first in range(0, len(packed), WIDTH)]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
