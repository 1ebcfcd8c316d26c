"""Who holds a folder: a process, told apart from a later one that has got the same number."""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from enum import Enum
from pathlib import Path
from uuid import uuid4

MOST_COMMAND = 200
"""Letters of a command line that a message shows."""
PROC = Path("/proc")


class Life(Enum):
    """Whether the process that wrote a lock file is still at work."""

    HERE = "it runs on this machine"
    GONE = "it has ended"
    ELSEWHERE = "it is on another machine, or out of sight, so that nobody here can say"


@dataclass(frozen=True, kw_only=True)
class Holder:
    """A run that holds a folder.

    Parameters
    ----------
    pid : int
    host, system : str
        Name of the machine; its start and the space in which process numbers count, where the system says so.
    began : str
        When the process began, as its system counts: a number used again began later.
    since, command : str
        Since when the folder is held, and the command line, both to be shown.
    token : str
        Of this hold alone.
    within : str
        Token of the hold for which the work is done, as of a fleet; empty where it is nobody's.
    """

    pid: int
    host: str
    system: str
    began: str
    since: str
    command: str
    token: str
    within: str = ""

    @property
    def words(self) -> str:
        """Who it is, in a line."""
        return f"{self.command} (process {self.pid} on {self.host}, since {self.since})"

    @property
    def life(self) -> Life:
        """Whether it is still at work, as far as this machine can tell."""
        if self.host != platform.node():
            return Life.ELSEWHERE
        boot, _, space = self.system.partition("/")
        own_boot, _, own_space = system().partition("/")
        if boot != own_boot:
            return Life.GONE  # the machine was started again since
        if space != own_space:
            return Life.ELSEWHERE
        return Life.HERE if beginning(self.pid) == self.began else Life.GONE

    def text(self) -> str:
        """Return what the lock file holds."""
        return json.dumps(asdict(self), indent=1) + "\n"


def this_process(within: str = "") -> Holder:
    """Return a new holder that this process is."""
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name  # python -m mechid
    command = " ".join([name, *sys.argv[1:]])
    return Holder(
        pid=os.getpid(),
        host=platform.node(),
        system=system(),
        began=beginning(os.getpid()),
        since=datetime.now().astimezone().isoformat(sep=" ", timespec="seconds"),
        command=command if len(command) <= MOST_COMMAND else command[: MOST_COMMAND - 3] + "...",
        token=uuid4().hex,
        within=within,
    )


def read_holder(text: str) -> Holder | None:
    """Return the holder that a lock file tells of; None where it tells of none."""
    try:
        found = json.loads(text)
    except ValueError:
        return None
    if not isinstance(found, Mapping):
        return None
    fields = {name: found.get(name) for name in Holder.__dataclass_fields__}
    are_texts = all(isinstance(value, str) for name, value in fields.items() if name != "pid")
    return Holder(**fields) if are_texts and type(fields["pid"]) is int else None  # type: ignore[arg-type]


def system() -> str:
    """Return what tells this start of the machine, and this space of process numbers, from others.

    A part is empty where the system does not say.
    """
    try:
        boot = (PROC / "sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return f"{boot}/{(PROC / 'self/ns/pid').readlink().name}"
    except OSError:
        return "/"


def beginning(pid: int) -> str:
    """Return when a process began, as text to be compared; empty where there is none.

    On Linux it is counted from the machine's start, so that a clock that is set changes nothing. A process that has
    ended, and whose end its parent has not asked for, is none.
    """
    if sys.platform != "linux":
        return _beginning_elsewhere(pid)
    try:
        fields = (PROC / str(pid) / "stat").read_bytes().rpartition(b")")[2].split()
    except OSError:
        return ""
    return "" if fields[0] in (b"Z", b"X") else fields[19].decode()


def _beginning_elsewhere(pid: int) -> str:
    import psutil

    try:
        return str(round(psutil.Process(pid).create_time()))
    except psutil.Error:
        return ""
