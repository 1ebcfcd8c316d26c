"""Workers and a scheduler that are lost while they work for a bootstrap."""

import signal
import sys
import threading
import time
from functools import partial
from pathlib import Path

from faults.reference import Trial, afterwards, last, numbers, run, unexpected

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
LOST = ("a worker", "the scheduler")


def workers(reference, count):
    """Yield trials of a worker killed, and of a scheduler killed, each at another instant."""
    for k in range(count or 4):
        yield Trial(k, f"{LOST[k % 2]} is lost", partial(_lost, reference, LOST[k % 2], 1.0 + k))


def _lost(reference, which, after_s):
    from dask_cluster import cluster

    whole, _ = reference.whole("bootstrap")
    out, folder = reference.empty("lent"), reference.empty("cluster")
    folder.mkdir(parents=True)
    with cluster(folder, workers=2) as here:
        victim = here.workers[0] if which == "a worker" else here.scheduler
        command = [*reference.command("bootstrap", out), "--scheduler", here.address]
        threading.Thread(
            target=_killed_when_begun, args=(out / "bootstrap.jsonl", victim, after_s), daemon=True
        ).start()
        done = run(command)
    faults = unexpected(done.stderr)
    if done.returncode == 0:
        faults += [] if numbers(out, "bootstrap") == whole else ["other numbers"]
    elif which == "a worker" or done.returncode != 2:
        faults.append(f"exit code {done.returncode}: {last(done.stderr)}")
    return {
        "faults": faults + afterwards(reference, "bootstrap", out),
        "code": done.returncode,
        "said": last(done.stderr),
    }


def _killed_when_begun(journal, victim, after_s):
    until = time.monotonic() + 120.0
    while not journal.exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(after_s)
    victim.send_signal(signal.SIGKILL)
