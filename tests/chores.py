"""Tasks for workers, and what makes a worker odd: of a module, so that other processes find them."""

import os
import time
from concurrent.futures import Executor, Future
from pathlib import Path

from mechid.errors import FitError
from mechid.identification.computation import worker
from mechid.kernel.source import fingerprint


def squared(shift, number):
    return (number + shift) ** 2


def logged(folder, seconds, number):
    """Note in a file who did what, then take so long."""
    with (Path(folder) / f"{os.getpid()}.log").open("a") as file:
        file.write(f"{number}\n")
    time.sleep(seconds)
    return number**2


def executions(folder):
    """Return the numbers that `logged` was asked for, by process."""
    return {int(file.stem): [int(line) for line in file.read_text().split()] for file in Path(folder).glob("*.log")}


def failing(last, number):
    if number >= last:
        raise FitError(f"task {number}")
    return number


def hash_of_kernel(mechanism):
    """Return the hash by which the kernel of a mechanism is found."""
    return fingerprint(mechanism.plant, 4)


def slow_first(number):
    """Take longest for the first task."""
    time.sleep(0.2 if number == 0 else 0.0)
    return number


def fatal(number):
    """End the process without a word."""
    os._exit(1)


def of_another_version():
    """Make this process one of another mechid."""
    worker.installation = lambda: "mechid 0.0.9"


def without_cache(folder):
    """Make this process one with another cache."""
    os.environ["MECHID_CACHE"] = folder


def cache_of(number):
    """Return the folder for kernels, which is there."""
    assert Path(os.environ["MECHID_CACHE"]).is_dir()
    return os.environ["MECHID_CACHE"]


class Recorded(Executor):
    """Does at once what it is given, and remembers it."""

    def __init__(self, workers):
        self.calls, self._max_workers = [], workers

    def submit(self, fn, /, *args, **kwargs):
        self.calls.append(args)
        future = Future()
        future.set_result(fn(*args, **kwargs))
        return future
