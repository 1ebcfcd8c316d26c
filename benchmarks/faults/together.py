"""Several processes at once in one folder, and with one empty cache."""

import os
import shutil
import subprocess
from functools import partial

from faults.reference import Trial, afterwards, last, numbers, unexpected

COUNTS = (2, 4)


def one_folder(reference, count):
    """Yield trials of two and four runs into one folder: one works, the others are refused."""
    for k in range(count or 4):
        verb = ("identify", "bootstrap")[k // len(COUNTS) % 2]
        processes = COUNTS[k % len(COUNTS)]
        yield Trial(k, f"{verb}, {processes} at once", partial(_folder, reference, verb, processes))


def _folder(reference, verb, processes):
    reference.whole(verb)
    out = reference.empty("shared")
    ended = _at_once([reference.command(verb, out) for _ in range(processes)])
    faults = [fault for _, said in ended for fault in unexpected(said)]
    worked = [code for code, _ in ended if code in (0, 5)]
    refused = [said for code, said in ended if code == 2 and "another run is using it" in last(said)]
    if len(worked) + len(refused) != processes or not worked:
        faults.append(f"exit codes {[code for code, _ in ended]}")
    return {"faults": faults + afterwards(reference, verb, out), "refused": len(refused)}


def one_cache(reference, count):
    """Yield trials of two and four runs that need the same kernels, of which none is there."""
    for k, processes in enumerate(COUNTS[: count or 2]):
        yield Trial(k, f"{processes} identify with one empty cache", partial(_cache, reference, processes))


def _cache(reference, processes):
    whole, _ = reference.whole("identify")
    cache, outs = reference.empty("one_cache"), [reference.empty(f"own_{k}") for k in range(processes)]
    ended = _at_once([reference.command("identify", out) for out in outs], MECHID_CACHE=str(cache))
    faults = [fault for _, said in ended for fault in unexpected(said)]
    faults += [f"exit code {code}: {last(said)}" for code, said in ended if code not in (0, 5)]
    faults += [
        "other numbers" for out in outs if (out / "estimate.json").exists() and numbers(out, "identify") != whole
    ]
    sources = list(cache.glob("*/kernel_*.py"))
    compiled = [len(list(path.parent.glob(f"__pycache__/{path.stem}.run-*.nbc"))) for path in sources]
    faults += [f"a kernel compiled more than once: {compiled}"] if any(n != 1 for n in compiled) else []
    shutil.rmtree(cache, ignore_errors=True)
    return {"faults": faults, "kernels": len(sources)}


def _at_once(commands, **environment):
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True, "env": os.environ | environment}
    running = [subprocess.Popen(command, **pipes) for command in commands]
    said = [process.communicate()[1] for process in running]
    return [(process.returncode, text) for process, text in zip(running, said, strict=True)]
