"""Execution of batches of tasks on a worker, of problems that are sent to it once.

What a worker is given and what it gives back are texts and bytes, so that one with another mechid takes them too, and
is refused by name instead of stumbling over a pickle.
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
    """Return in a line what results depend on: mechid with a digest of its sources, Python, the numerical libraries."""
    python = ".".join(platform.python_version_tuple()[:2])
    others = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return f"mechid {source_digest()}, Python {python}, {others}"


def source_digest() -> str:
    """Return the version of mechid and a digest of its sources: other code may go another way."""
    root = Path(__file__).parents[2]
    total = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        total.update(file.read_bytes())
    return f"{version('mechid')} {total.hexdigest()[:16]}"


DONE, LACKING, REFUSED = "done", "lacking", "refused"

Answer = tuple[str, str, bytes]
"""How it went, the worker's name, and a pickled `Batch`, or what is installed on a worker that is refused."""


@dataclass(frozen=True)
class Batch:
    """Results of the tasks of a batch that did not fail, in order, the seconds of each, and what the next one raised.

    `processor` and `remarks` are of the worker.
    """

    results: Sequence[Any]
    seconds: Sequence[float]
    error: BaseException | None
    processor: str
    remarks: tuple[str, ...] = ()


_functions: OrderedDict[str, Callable[[Any], Any]] = OrderedDict()
_lock = threading.Lock()


def work(installed: str, digest: str, function: bytes | None, tasks: bytes) -> Answer:
    """Work on a batch.

    Parameters
    ----------
    installed : str
        What is installed where the tasks come from; a worker with anything else does nothing.
    digest : str
        Of the pickled function, by which the worker knows it again.
    function : bytes or None
        The pickled function, with the problem in it; None where the worker may know it.
    tasks : bytes
        The pickled list of tasks.
    """
    name = f"{socket.gethostname()}:{os.getpid()}:{threading.get_ident()}"
    if installed != installation():
        return REFUSED, name, installation().encode()
    try:
        known = _known(digest, function)
        if known is None:
            return LACKING, name, b""
        remarks = kernels_kept()
        with on_one_core():
            batch = _worked(known, pickle.loads(tasks), remarks)
    except Exception as error:
        batch = Batch([], [], _described(error), processor())
    return DONE, name, _pickled(batch)


def _known(digest: str, function: bytes | None) -> Callable[[Any], Any] | None:
    """Return the function of a digest, None where it was never here."""
    with _lock:
        found = _functions.pop(digest, None)
        if found is None and function is not None:
            found = pickle.loads(function)
        if found is not None:
            _functions[digest] = found
        while len(_functions) > WORK.problems_kept:
            _functions.popitem(last=False)
    return found


def _worked(function: Callable[[Any], Any], tasks: Sequence[Any], remarks: tuple[str, ...]) -> Batch:
    results, seconds, fault = [], [], None
    for task in tasks:
        began = time.perf_counter()
        try:
            results.append(function(task))
        except Exception as error:
            fault = _described(error)
            break
        seconds.append(time.perf_counter() - began)
    return Batch(results, seconds, fault, processor(), remarks)


def _described(error: Exception) -> Exception:
    """Return an error that can be sent, with what the worker's traceback says."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        error = RuntimeError(f"{type(error).__name__}: {error}")
    error.add_note(f"on {socket.gethostname()}:\n{''.join(traceback.format_exception(error))}")
    return error


def _pickled(batch: Batch) -> bytes:
    try:
        return pickle.dumps(batch, protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        return pickle.dumps(Batch([], [], _described(error), processor()))


@lru_cache(maxsize=1)
def processor() -> str:
    """Return the type of processor for which kernels are compiled here."""
    return os.environ.get("NUMBA_CPU_NAME") or str(llvmlite.binding.get_host_cpu_name())


@lru_cache(maxsize=1)
def kernels_kept() -> tuple[str, ...]:
    """Make sure that kernels can be kept, in a temporary folder if nowhere else, and return what is to be said of it.

    The folder is this process's alone and goes with it: others' code is not to be found there.
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
        return (f"{why}: its kernels are compiled in a temporary folder, anew in each process",)
