"""A folder that another run holds: in words the process that started the tests, which is there as long as they are."""

import os
from dataclasses import replace

from filelock import FileLock

from mechid.locks import LOCK_NAME
from mechid.locks.folder import GUARD_NAME
from mechid.locks.holder import this_process

_LOCKED = []
"""Locks of the folders: this process has them as long as it runs."""


def hold_by_parent(folder):
    """Hold a folder as the parent process would, and return its number."""
    folder.mkdir(parents=True, exist_ok=True)
    guard = FileLock(folder / GUARD_NAME)
    guard.acquire(blocking=False)
    _LOCKED.append(guard)
    parent = replace(this_process(), pid=os.getppid(), command="mechid identify bench")
    (folder / LOCK_NAME).write_text(parent.text(), encoding="utf-8")
    return parent.pid
