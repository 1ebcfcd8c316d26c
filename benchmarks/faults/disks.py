"""A disk that is full at any write, renames that fail, and a kernel cache that cannot be written to."""

import os
import shutil
import subprocess
from contextlib import contextmanager
from functools import partial

import numpy as np

from faults.layers import with_layer
from faults.reference import Trial, afterwards, half_written, last, numbers, run, unexpected

CANNOT = "cannot be written to"
VERBS = ("identify", "bootstrap", "profile", "budget")
PAGE = 4096


@contextmanager
def memory_disk(place, size):
    """Mount a file system of so many bytes, which goes again."""
    place.mkdir(parents=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", place], check=True)


def _may_mount():
    return os.geteuid() == 0 and shutil.which("mount") is not None


def full(reference, count):
    """Yield trials of disks from none to all of the room that a command needs, evenly over its writes."""
    if not _may_mount():
        return
    for k in range(count or 24):
        verb = VERBS[k % len(VERBS)]
        share = (k // len(VERBS) + 0.5) / np.ceil((count or 24) / len(VERBS))
        yield Trial(k, f"{verb}, {share:.3f} of the room it needs", partial(_full, reference, verb, float(share)))


def _full(reference, verb, share):
    reference.whole(verb)
    needed = sum(_pages(path) for path in (reference.folder / verb).rglob("*") if path.is_file())
    disk = reference.empty("disk")
    size = max(int(share * needed) // PAGE * PAGE, 2 * PAGE)
    with memory_disk(disk, size):
        out = disk / "out"
        done = run(reference.command(verb, out))
        faults = unexpected(done.stderr) + half_written(out)
        if done.returncode != 2 or CANNOT not in last(done.stderr):
            faults.append(f"exit code {done.returncode}: {last(done.stderr)}")
        subprocess.run(["mount", "-o", "remount,size=256m", disk], check=True)
        faults += afterwards(reference, verb, out)
    return {"faults": faults, "bytes": size, "said": last(done.stderr)}


def _pages(path):
    return -(-path.stat().st_size // PAGE) * PAGE


def renames(reference, count):
    """Yield trials in which the k-th rename fails as on a network file system whose server has forgotten the file."""
    for k in range(count or 16):
        verb = VERBS[k % len(VERBS)]
        yield Trial(k, f"{verb}, rename {k // 4 + 1}", partial(_rename, reference, verb, k // 4 + 1))


def _rename(reference, verb, at):
    reference.whole(verb)
    out = reference.empty("rename")
    done = run(reference.command(verb, out), **with_layer(f"rename:{at}"))
    faults = unexpected(done.stderr) + half_written(out)
    happened = done.returncode not in (0, 5)
    if happened and (done.returncode != 2 or CANNOT not in last(done.stderr)):
        faults.append(f"exit code {done.returncode}: {last(done.stderr)}")
    return {"faults": faults + afterwards(reference, verb, out), "happened": happened, "said": last(done.stderr)}


def read_only(reference, count):
    """Yield trials of a cache that has the kernels and cannot be written to, and of an empty one."""
    if not _may_mount():
        return
    for k, has_kernels in enumerate((True, False)[: count or 2]):
        words = "with the kernels" if has_kernels else "empty"
        yield Trial(k, f"identify, a cache {words} that cannot be written to", partial(_cache, reference, has_kernels))


def _cache(reference, has_kernels):
    whole, _ = reference.whole("identify")
    disk, out = reference.empty("cache"), reference.empty("cached")
    with memory_disk(disk, "256m"):
        asked = {"MECHID_CACHE": str(disk / "mechid")}
        if has_kernels:
            run(reference.command("identify", out), **asked)
            shutil.rmtree(out)
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        done = run(reference.command("identify", out), **asked)
    faults = unexpected(done.stderr)
    if has_kernels:
        is_good = done.returncode in (0, 5) and numbers(out, "identify") == whole
        faults += [] if is_good else [f"exit code {done.returncode}: {last(done.stderr)}"]
    elif done.returncode != 2:
        faults.append(f"exit code {done.returncode}: {last(done.stderr)}")
    return {"faults": faults, "said": last(done.stderr)}
