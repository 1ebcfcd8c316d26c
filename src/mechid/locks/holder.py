"""Record of the run that holds a folder: the process, its machine and its command line, for messages to other runs."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from uuid import uuid4

MOST_COMMAND = 200
"""Maximum number of characters of a command line shown in messages."""


@dataclass(frozen=True, kw_only=True)
class Holder:
    """Run that holds a folder.

    Parameters
    ----------
    pid : int
    host : str
        Name of the machine.
    since, command : str
        Time of locking and command line, shown in messages.
    token : str
        Unique token of this lock.
    within : str
        Token of the enclosing lock for which the work is done, such as that of a fleet; empty if there is none.
    """

    pid: int
    host: str
    since: str
    command: str
    token: str
    within: str = ""

    @property
    def words(self) -> str:
        """One-line description of the process."""
        return f"{self.command} (process {self.pid} on {self.host}, since {self.since})"

    @property
    def is_elsewhere(self) -> bool:
        """Whether the process is on another machine."""
        return self.host != platform.node()

    def text(self) -> str:
        """Return the content of the record."""
        return json.dumps(asdict(self), indent=1) + "\n"


def this_process(within: str = "") -> Holder:
    """Return a new holder that describes this process."""
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name  # python -m mechid
    command = " ".join([name, *sys.argv[1:]])
    return Holder(
        pid=os.getpid(),
        host=platform.node(),
        since=datetime.now().astimezone().isoformat(sep=" ", timespec="seconds"),
        command=command if len(command) <= MOST_COMMAND else command[: MOST_COMMAND - 3] + "...",
        token=uuid4().hex,
        within=within,
    )


def read_holder(text: str) -> Holder | None:
    """Return the holder described by a record, or None if the record is malformed."""
    try:
        found = json.loads(text)
    except ValueError:
        return None
    if not isinstance(found, Mapping):
        return None
    fields = {name: found.get(name) for name in Holder.__dataclass_fields__}
    are_texts = all(isinstance(value, str) for name, value in fields.items() if name != "pid")
    return Holder(**fields) if are_texts and type(fields["pid"]) is int else None  # type: ignore[arg-type]
