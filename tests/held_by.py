"""A folder that another run holds: the process that started the tests, which is there as long as they are."""

import os
from dataclasses import replace

from mechid.holding import LOCK_NAME
from mechid.holding.holder import process_start, this_process


def hold_by_parent(folder):
    """Write the lock file that the parent process would have left, and return its number."""
    folder.mkdir(parents=True, exist_ok=True)
    parent = replace(
        this_process(), pid=os.getppid(), began=process_start(os.getppid()), command="mechid identify bench"
    )
    (folder / LOCK_NAME).write_text(parent.text(), encoding="utf-8")
    return parent.pid
