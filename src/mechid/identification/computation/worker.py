"""Execution of batches of tasks on a worker, for problems that are sent to it once.

Input and output of a worker are texts and bytes. A worker with another version of mechid can therefore receive them,
and is refused by name instead of failing on a pickle.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import pickle
import platform
import shutil
import socket
import tempfile
import threading
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import llvmlite.binding

from mechid.identification.computation.parallel import on_one_core
from mechid.identification.computation.settings import WORK
from mechid.writing import CACHE, cache_folder

LIBRARIES = ("numpy", "scipy", "numba")


@lru_cache(maxsize=1)
def installation() -> str:
    """Return a line with everything that results depend on: mechid with a digest of its sources, Python, libraries."""
    python = ".".join(platform.python_version_tuple()[:2])
    others = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return f"mechid {source_digest()}, Python {python}, {others}"


def source_digest() -> str:
    """Return the version of mechid and a digest of its sources, because other code may take other steps."""
    root = Path(__file__).parents[2]
    total = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        total.update(file.read_bytes())
    return f"{version('mechid')} {total.hexdigest()[:16]}"


DONE, LACKING, REFUSED = "done", "lacking", "refused"

Answer = tuple[str, str, bytes]
"""Status, the worker's name, and a pickled `Batch`, or the installation of a refused worker."""


@dataclass(frozen=True)
class Batch:
    """Results of a batch's tasks in order, up to the first failure, their times, and the error of the failed task.

    `processor` and `remarks` describe the worker.
    """

    results: Sequence[Any]
    seconds: Sequence[float]
    error: BaseException | None
    processor: str
    remarks: tuple[str, ...] = ()


_functions: OrderedDict[str, Callable[[Any], Any]] = OrderedDict()
_lock = threading.Lock()


def work(installed: str, digest: str, function: bytes | None, tasks: bytes) -> Answer:
    """Execute a batch.

    Parameters
    ----------
    installed : str
        Installation of the sender; a worker with any other one does nothing.
    digest : str
        Digest of the pickled function, by which the worker finds it in its cache.
    function : bytes or None
        Pickled function, including the problem; None if the worker may have it.
    tasks : bytes
        Pickled list of tasks.
    """
    name = f"{socket.gethostname()}:{os.getpid()}:{threading.get_ident()}"
    # Checked before anything is unpickled: a pickle of another version may fail in any way.
    if installed != installation():
        return REFUSED, name, installation().encode()
    try:
        known = _cached_function(digest, function)
        if known is None:
            return LACKING, name, b""
        remarks = ensure_kernel_cache()
        with on_one_core():
            batch = _run_tasks(known, pickle.loads(tasks), remarks)
    except Exception as error:
        batch = Batch([], [], _describe_error(error), processor())
    return DONE, name, _pickle_batch(batch)


def _cached_function(digest: str, function: bytes | None) -> Callable[[Any], Any] | None:
    """Return the function of a digest, None if it was never received."""
    with _lock:
        # Removed and inserted again, so that the least recently used function is the first to go.
        found = _functions.pop(digest, None)
        if found is None and function is not None:
            found = pickle.loads(function)
        if found is not None:
            _functions[digest] = found
        while len(_functions) > WORK.problems_kept:
            _functions.popitem(last=False)
    return found


def _run_tasks(function: Callable[[Any], Any], tasks: Sequence[Any], remarks: tuple[str, ...]) -> Batch:
    results, seconds, fault = [], [], None
    for task in tasks:
        began = time.perf_counter()
        try:
            results.append(function(task))
        except Exception as error:
            fault = _describe_error(error)
            break
        seconds.append(time.perf_counter() - began)
    return Batch(results, seconds, fault, processor(), remarks)


def _describe_error(error: Exception) -> Exception:
    """Return an error that can be pickled, with the worker's traceback as a note."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        error = RuntimeError(f"{type(error).__name__}: {error}")
    error.add_note(f"on {socket.gethostname()}:\n{''.join(traceback.format_exception(error))}")
    return error


def _pickle_batch(batch: Batch) -> bytes:
    try:
        return pickle.dumps(batch, protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        return pickle.dumps(Batch([], [], _describe_error(error), processor()))


@lru_cache(maxsize=1)
def processor() -> str:
    """Return the type of processor for which kernels are compiled here."""
    return os.environ.get("NUMBA_CPU_NAME") or str(llvmlite.binding.get_host_cpu_name())


@lru_cache(maxsize=1)
def ensure_kernel_cache() -> tuple[str, ...]:
    """Ensure a writable cache of kernels, if necessary in a temporary folder, and return remarks about it.

    The temporary folder belongs to this process and is removed with it, so that no other user's code can be loaded from
    it.
    """
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return ()
    except OSError as error:
        temporary = tempfile.mkdtemp(prefix="mechid-kernels-")
        atexit.register(shutil.rmtree, temporary, ignore_errors=True)
        os.environ[CACHE] = temporary
        why = f"cannot write to {folder} ({error.strerror})"
        return (f"{why}: its kernels are compiled in a temporary folder, again in each process",)
