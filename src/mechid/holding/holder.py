"""Identity of the process that holds a folder, unambiguous even if its process number is reused."""

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

MAX_COMMAND_LENGTH = 200
"""Maximum number of characters of a command line shown in messages."""
PROC = Path("/proc")


class Life(Enum):
    """State of the process that wrote a lock file, as far as it is visible from this machine."""

    HERE = "it runs on this machine"
    GONE = "it has ended"
    ELSEWHERE = "it is on another machine or in another process namespace, so its state is unknown"


@dataclass(frozen=True, kw_only=True)
class Holder:
    """A run that holds a folder.

    Parameters
    ----------
    pid : int
    host, system : str
        Name of the machine; boot identifier and process namespace, if the system reports them.
    began : str
        Start time of the process, as counted by its system; it distinguishes processes with the same number.
    since, command : str
        Time of locking and command line, shown in messages.
    token : str
        Unique token of this lock.
    within : str
        Token of the enclosing lock for which the work is done, such as that of a fleet; empty if there is none.
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
        """One-line description of the process."""
        return f"{self.command} (process {self.pid} on {self.host}, since {self.since})"

    @property
    def life(self) -> Life:
        """State of the process, as far as it is visible from this machine."""
        if self.host != platform.node():
            return Life.ELSEWHERE
        boot, _, space = self.system.partition("/")
        own_boot, _, own_space = system_identity().partition("/")
        if boot != own_boot:
            return Life.GONE  # the machine has been rebooted
        if space != own_space:
            return Life.ELSEWHERE
        return Life.HERE if process_start(self.pid) == self.began else Life.GONE

    def text(self) -> str:
        """Return the content of the lock file."""
        return json.dumps(asdict(self), indent=1) + "\n"


def this_process(within: str = "") -> Holder:
    """Return a new holder that describes this process."""
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name  # python -m mechid
    command = " ".join([name, *sys.argv[1:]])
    return Holder(
        pid=os.getpid(),
        host=platform.node(),
        system=system_identity(),
        began=process_start(os.getpid()),
        since=datetime.now().astimezone().isoformat(sep=" ", timespec="seconds"),
        command=command if len(command) <= MAX_COMMAND_LENGTH else command[: MAX_COMMAND_LENGTH - 3] + "...",
        token=uuid4().hex,
        within=within,
    )


def read_holder(text: str) -> Holder | None:
    """Return the holder described by a lock file, or None if the content is malformed."""
    try:
        found = json.loads(text)
    except ValueError:
        return None
    if not isinstance(found, Mapping):
        return None
    fields = {name: found.get(name) for name in Holder.__dataclass_fields__}
    are_texts = all(isinstance(value, str) for name, value in fields.items() if name != "pid")
    return Holder(**fields) if are_texts and type(fields["pid"]) is int else None  # type: ignore[arg-type]


def system_identity() -> str:
    """Return the boot identifier and the process namespace of this machine, separated by a slash.

    Both are empty if the system does not report them.
    """
    try:
        boot = (PROC / "sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return f"{boot}/{(PROC / 'self/ns/pid').readlink().name}"
    except OSError:
        return "/"


def process_start(pid: int) -> str:
    """Return the start time of a process as text for comparison; empty if there is no such process.

    On Linux it is counted from the boot of the machine, so that changes of the clock do not matter. A zombie, which
    has ended but has not been waited for, does not count as a process.
    """
    if sys.platform != "linux":
        return _process_start_by_psutil(pid)
    try:
        # The command name, in brackets, may contain spaces and brackets itself: fields are counted after the last one.
        fields = (PROC / str(pid) / "stat").read_bytes().rpartition(b")")[2].split()
    except OSError:
        return ""
    return "" if fields[0] in (b"Z", b"X") else fields[19].decode()


def _process_start_by_psutil(pid: int) -> str:
    import psutil

    try:
        return str(round(psutil.Process(pid).create_time()))
    except psutil.Error:
        return ""
