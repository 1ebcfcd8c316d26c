"""Runs that are killed, or interrupted by Ctrl-C, at random instants of all that they do."""

import os
import signal
import subprocess
import time
from functools import partial

import numpy as np

from faults.reference import Trial, afterwards, last, unexpected

KILLED = ("identify", "identify", "bootstrap", "profile", "identify")
"""In turn: the search, the joint fit, the errors and the report are all of identify."""
RERUN = ("budget", "fleet")
COUNT, OF_RERUN = 50, 6
INTERRUPTED = 130


def kills(reference, count):
    """Yield the trials of kill -9."""
    yield from _trials(reference, count or COUNT, signal.SIGKILL)


def interrupts(reference, count):
    """Yield the trials of Ctrl-C."""
    yield from _trials(reference, count or 20, signal.SIGINT)


def _trials(reference, count, how):
    rng = np.random.default_rng([reference.seed, how])
    verbs = [KILLED[k % len(KILLED)] for k in range(count)]
    verbs += [RERUN[k % len(RERUN)] for k in range(min(OF_RERUN, count))]
    shares = rng.uniform(0.05, 0.98, len(verbs))
    for k, (verb, share) in enumerate(zip(verbs, shares, strict=True)):
        yield Trial(k, f"{verb} at {share:.3f} of its time", partial(_one, reference, verb, float(share), how))


def _one(reference, verb, share, how):
    _, took = reference.whole(verb)
    out = reference.empty("killed")
    process = subprocess.Popen(
        reference.command(verb, out),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    time.sleep(share * took)
    ended_before = process.poll() is not None
    if not ended_before:
        process.send_signal(how)
    said = process.communicate()[1]
    faults = [] if ended_before or how == signal.SIGKILL else _of_interrupt(process.returncode, said)
    stage = [line for line in said.splitlines() if line.startswith("stage")]
    return {
        "faults": faults + afterwards(reference, verb, out),
        "ended_before": ended_before,
        "at": stage[-1][:120] if stage else last(said)[:120],
    }


def _of_interrupt(code, said):
    """Return what is not as promised of an interrupted run; before its first line Python itself ends it."""
    if code in (0, 5):  # its last moments cannot be interrupted
        return unexpected(said)
    return unexpected(said) + ([] if code == INTERRUPTED else [f"exit code {code}: {last(said)}"])
