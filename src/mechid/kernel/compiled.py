"""Compilation of generated modules by Numba, their cache on disk, and the buffers of a run."""

from __future__ import annotations

import gc
import importlib.util
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from threading import Lock, Thread
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.errors import UsageError
from mechid.kernel.cache_files import is_sealed, is_whole, lock_kernel, remove_kernel, seal
from mechid.kernel.compiler import cache_signatures
from mechid.kernel.source import fingerprint, generate, lanes_for
from mechid.locks import sweep
from mechid.plant.plant import Plant
from mechid.writing import CACHE, cache_folder, write_atomically

SUCCESS, DIVERGED, CHATTER = 0, 1, 2
_ONE_AT_A_TIME = Lock()
"""Held while a module is compiled: other threads that need it wait."""


@dataclass(frozen=True)
class Kernel:
    """A compiled plant; the generated module documents `begin` and `run`.

    `seconds` is the time for compiling or loading it; `cached` is true if it was loaded.
    """

    plant: Plant
    path: Path
    module: ModuleType
    begin: Callable[..., None]
    run: Callable[..., int]
    seconds: float
    cached: bool

    @property
    def lanes(self) -> int:
        """Number of sensitivity lanes."""
        return int(self.module.NL)

    @property
    def text(self) -> str:
        """Source of the kernel."""
        return self.path.read_text(encoding="utf-8")


def version_folder() -> Path:
    """Return the cache folder of this version of mechid."""
    return cache_folder() / f"v{version('mechid')}"


def kernel_for(plant: Plant, sensitivities: int = 0) -> Kernel:
    """Return the compiled kernel of a plant, from the cache if it has been compiled before.

    Parameters
    ----------
    plant : Plant
    sensitivities : int
        Largest number of parameters whose sensitivities a run requests.
    """
    return _kernel(plant, lanes_for(sensitivities))


def is_compiled(plant: Plant, sensitivities: int = 0) -> bool:
    """Return whether the cache holds the kernel that `kernel_for` would return."""
    return is_whole(_path(plant, lanes_for(sensitivities)))


@lru_cache(maxsize=64)
def _kernel(plant: Plant, lanes: int) -> Kernel:
    began = time.perf_counter()
    path = _path(plant, lanes)
    cached = is_whole(path)
    module = compiled_module(path.stem, lambda: generate(plant, lanes), lambda made: _compile(made, plant))
    return Kernel(plant, path, module, module.begin, module.run, time.perf_counter() - began, cached)


def compiled_module(name: str, text: Callable[[], str], call: Callable[[ModuleType], None]) -> ModuleType:
    """Return a generated module from the cache folder; write and compile it if it is missing.

    Parameters
    ----------
    name : str
        Stem of its file.
    text : callable
        Returns its text.
    call : callable
        Calls the module's entry points once with empty data, which compiles them.

    Raises
    ------
    UsageError
        The cache cannot be written to.
    """
    path = version_folder() / f"{name}.py"
    try:
        with _ONE_AT_A_TIME:
            if is_whole(path):
                return _load(path, call)
            with lock_kernel(path):
                return _make(path, text, call)
    except OSError as error:
        remedy = f"make room, or name another folder in {CACHE}"
        raise UsageError(f"{cache_folder()}: the kernel cannot be kept there ({error.strerror}); {remedy}") from error


def _make(path: Path, text: Callable[[], str], call: Callable[[ModuleType], None]) -> ModuleType:
    """Return a module that was missing or incomplete; another process may have compiled it meanwhile."""
    # A process was killed before it could seal a complete kernel.
    if path.exists() and not is_sealed(path):
        # A file that was cut off may raise anything on import; it is then compiled again.
        with suppress(Exception):
            return _load(path, call)
    if not is_whole(path):
        sweep(path.parent)
        remove_kernel(path)
        # The incomplete file may have been imported already, under the same name.
        sys.modules.pop(_module_name(path), None)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, text())
    return _load(path, call)


def _load(path: Path, call: Callable[[ModuleType], None]) -> ModuleType:
    """Import a module and call it, which loads or compiles it; Numba recompiles code made for another processor."""
    module = _import(path)
    with cache_signatures(), _pause_collector():
        _on_own_stack(call, module)
    # Numba writes its machine code during the call, so the digests are complete only now.
    seal(path)
    return module


@contextmanager
def _pause_collector() -> Iterator[None]:
    """Let Python's garbage collector rest: it scans the objects of a compilation again and again, and frees few."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _path(plant: Plant, lanes: int) -> Path:
    return version_folder() / f"kernel_{fingerprint(plant, lanes)}.py"


def _module_name(path: Path) -> str:
    return f"mechid_{path.stem}"


def _import(path: Path) -> ModuleType:
    name = _module_name(path)
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _compile(module: ModuleType, plant: Plant) -> None:
    """Call both entry points once with empty data, so that later calls find them compiled."""
    b = allocate(plant, module, samples=0, events=0, sensitive=False)
    # The values do not matter, only the types, by which Numba compiles.
    p = np.ones(len(plant.parameters))
    module.begin(p, b.directions, np.zeros(len(plant.inputs)), 0.0, np.zeros(0), np.zeros(0), b.discrete, b.w)
    module.run(p, b.directions, 0, np.array([0.0, 1e-4, 1e-4, 1e-4]), np.zeros(0), np.zeros(0), *b.run_arguments(0, 0))


def _on_own_stack(work: Callable[..., None], *arguments: object) -> None:
    """Run a function in a thread of its own and wait for it.

    Numba's deep recursion takes a fifth longer on top of a deep call stack in CPython 3.11. Ctrl-C does not wait for
    the thread.
    """
    done: Future[None] = Future()

    def run() -> None:
        try:
            work(*arguments)
        except BaseException as error:
            done.set_exception(error)
        else:
            done.set_result(None)

    # A daemon, so that an interrupted main thread can end the process at once.
    Thread(target=run, name="compilation", daemon=True).start()
    done.result()


@dataclass(frozen=True)
class Buffers:
    """Arrays that a run reads and writes, flat as the generated module expects them."""

    directions: FloatArray
    discrete: IntArray
    w: FloatArray
    y: FloatArray
    y_dot: FloatArray
    J: FloatArray
    events: FloatArray
    outputs: int
    lanes: int
    sensitive: bool

    def run_arguments(self, first: int, stop: int) -> tuple[FloatArray | IntArray, ...]:
        """Return the arguments of `run` after the excitation, for the samples of a block from `first` to `stop`."""
        part = slice(first * self.outputs, stop * self.outputs)
        rows = part if self.sensitive else slice(0, 0)
        block = (self.y[part], self.y_dot[rows], self.J[rows.start * self.lanes : rows.stop * self.lanes])
        return (self.discrete, self.w, *block, self.events)


def allocate(plant: Plant, module: ModuleType, *, samples: int, events: int, sensitive: bool) -> Buffers:
    """Return zeroed buffers for blocks of up to `samples` samples, with or without sensitivities."""
    n_y, lanes = len(plant.outputs), int(module.NL)
    rows = samples if sensitive else 0
    return Buffers(
        directions=np.zeros(len(plant.parameters) * lanes),
        discrete=np.zeros(int(module.DISCRETE), dtype=np.int64),
        w=aligned_zeros(int(module.SIZE)),
        y=np.zeros(samples * n_y),
        y_dot=np.zeros(rows * n_y),
        J=np.zeros(rows * n_y * lanes),
        events=np.zeros(events * (int(module.EVENT_LANES) + lanes)),
        outputs=n_y,
        lanes=lanes,
        sensitive=sensitive,
    )


def lane_places(module: ModuleType, row: int, lanes: int) -> IntArray:
    """Return the positions of a row of all lanes in the workspace; mirrors ``lane_place`` of the kernel."""
    lane, group = np.arange(lanes), int(module.LANES_PER_GROUP)
    return np.asarray((lane // group) * int(module.GROUP_SIZE) + row * group + lane % group, dtype=np.int64)


def aligned_zeros(size: int, boundary: int = 64) -> FloatArray:
    """Return zeros aligned to a cache line, so that no vector load straddles two lines."""
    # NumPy aligns to 16 bytes only: the array is longer by one line, and the view starts on the boundary.
    raw = np.zeros(size + boundary // 8)
    first = (-raw.ctypes.data % boundary) // 8
    return raw[first : first + size]
