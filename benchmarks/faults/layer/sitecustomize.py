"""Loaded by Python before a program: a clock that is set back, or a rename that fails as network file systems' do."""

import datetime
import errno
import os
import time

kind, _, number = os.environ.get("MECHID_FAULT", "").partition(":")


def set_back_after(seconds: float) -> None:
    """Let all clocks of the day go back by an hour, so long after the start."""
    told, began, real = time.time, time.monotonic(), datetime.datetime

    def now() -> float:
        return told() - 3600.0 * (time.monotonic() - began > seconds)

    class SetBack(real):
        @classmethod
        def now(cls, tz=None):
            return real.fromtimestamp(now(), tz)

    time.time, datetime.datetime = now, SetBack


def fail_rename(at: int) -> None:
    """Let one rename of this process, counted from 1, fail; those of the kernels' cache do not count."""
    rename, count = os.replace, [0]

    def replaced(source, target, **more):
        if ".part" in str(source) and "/v" not in str(target):
            count[0] += 1
            if count[0] == at:
                raise OSError(errno.ESTALE, os.strerror(errno.ESTALE), str(source), None, str(target))
        return rename(source, target, **more)

    os.replace = replaced


if kind == "clock":
    set_back_after(float(number))
if kind == "rename":
    fail_rename(int(number))
