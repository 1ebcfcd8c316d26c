"""Journal of a long computation: results on disk, from which a killed run resumes.

A step is a pure function of its inputs. Its result is written under the digest of its inputs, to the last bit, before
the next step begins. A resumed run repeats the same steps and takes their results from the journal. It therefore ends
with the numbers of an uninterrupted run, and repeats at most the step that was running. Each line contains its own
digest, so that damage is detected.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, Self

import numpy as np

from mechid.errors import UsageError
from mechid.identification.computation.parallel import Done, count_work, map_tasks
from mechid.identification.computation.worker import source_digest
from mechid.simulation.work import count, work_counter
from mechid.writing import attach_path, creating_folder

STARTED, STEP = "started", "step"
SEPARATOR = b', "check": "'
"""Text before the digest, which is the last entry of a line."""
DIGITS = 16
"""Hexadecimal digits of a line's digest: a damaged line passes once in 2e19."""
NEEDED: Mapping[str, Mapping[str, type | tuple[type, ...]]] = {
    STARTED: {"inputs": dict},
    STEP: {"step": str, "key": str, "seconds": (int, float), "work": int, "result": object, "rng": object},
}
"""Required keys of each event's line, with their types."""


def seal(entry: Mapping[str, object]) -> str:
    """Return the line of an entry, its digest at the end.

    Examples
    --------
    >>> seal({"event": "resumed"})
    '{"event": "resumed", "check": "497a82e0605ef488"}'
    """
    text = json.dumps(entry)
    return f'{text[:-1]}{SEPARATOR.decode()}{_digest(text.encode())}"}}'


def read_entries(path: Path, *, mends: bool = True) -> tuple[list[dict[str, Any]], str]:
    """Return the intact entries of a journal in order, and a notice of damaged lines; none for a missing file.

    Parameters
    ----------
    path : Path
    mends : bool
        Whether an incomplete last line is cut off in the file.

    Raises
    ------
    UsageError
        No line is an entry, not even one of an earlier version: it is another file.
    """
    if not path.exists():
        return [], ""
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    if mends and len(whole) < len(content):
        os.truncate(path, len(whole))
    found = [_entry(line) for line in whole.splitlines()]
    lines = [entry for entry in found if entry is not None]
    damaged = [number for number, entry in enumerate(found, 1) if entry is None]
    if damaged and not lines:
        if not any(map(_is_unsealed_entry, whole.splitlines())):
            raise UsageError(f"{path}: line {damaged[0]}: is no entry of a journal; move the file away")
        return (
            [],
            f"{path}: is from an earlier version of mechid; its lines are kept, and their steps are computed again",
        )
    return lines, _damage_notice(path, damaged)


def _entry(line: bytes) -> dict[str, Any] | None:
    """Return the entry of a line; None if it is damaged, or of another program."""
    text, _, check = line.rpartition(SEPARATOR)
    if check != f'{_digest(text + b"}")}"}}'.encode():
        return None
    try:
        entry = json.loads(text + b"}")
    except (ValueError, RecursionError):
        return None
    if not isinstance(entry, dict) or not isinstance(entry.get("event"), str):
        return None
    needed = NEEDED.get(entry["event"], {})
    return entry if all(key in entry and isinstance(entry[key], kind) for key, kind in needed.items()) else None


def _is_unsealed_entry(line: bytes) -> bool:
    """Tell whether a line is an entry of an earlier version that wrote no digests."""
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(entry, dict) and isinstance(entry.get("event"), str) and "check" not in entry


def _digest(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:DIGITS]


def _damage_notice(path: Path, damaged: list[int]) -> str:
    if not damaged:
        return ""
    lines = (
        f"line {damaged[0]} is" if len(damaged) == 1 else f"{len(damaged)} lines, the first of them {damaged[0]}, are"
    )
    return f"{path}: {lines} damaged and ignored; the results lost there are computed again"


RESUMED = "resumed"
VERSION = "version of mechid"
"""One of the inputs, because other code may take other steps."""


class Journal:
    """Results by the digest of their inputs; a journal without a file stores nothing.

    Attributes
    ----------
    saved_s : float
        Time that the steps taken from the journal took originally. Their work counts as if it were done now.
    notice : str
        Damage found in the file, in a line; empty if there was none.
    """

    def __init__(
        self, path: Path | None = None, known: Mapping[str, Mapping[str, Any]] | None = None, notice: str = ""
    ) -> None:
        self.path, self.known, self.lock, self.saved_s = path, dict(known or {}), Lock(), 0.0
        self.notice = notice
        self.inputs = ""

    @classmethod
    def open(cls, path: Path, inputs: Mapping[str, str], *, resume: bool = False, **entries: object) -> Self:
        """Open a journal for a computation from `inputs`, digests by name; a missing folder is created.

        A new run is appended, with `entries` in its first line; a resumed one continues the last run. An incomplete
        last line of a killed run is cut off; any other damaged line is ignored, and its step computed again.

        Raises
        ------
        UsageError
            The file cannot be written, is no journal, or the run to be resumed had other inputs.
        """
        inputs = with_version(inputs)
        with creating_folder(path.parent):
            lines, notice = read_entries(path)
            initial = max((i for i, line in enumerate(lines) if line["event"] == STARTED), default=None)
            if not resume or initial is None:
                journal = cls(path, notice=notice)
                journal.inputs = digest(inputs)
                journal.note(STARTED, **entries, inputs=inputs)
                return journal
            _refuse_others(path, lines[initial].get("inputs", {}), inputs)
            journal = cls(path, {line["key"]: line for line in lines[initial:] if line["event"] == STEP}, notice)
            journal.inputs = digest(inputs)
            journal.note(RESUMED)
        return journal

    def note(self, event: str, **entries: object) -> None:
        """Append a line; it is on the disk when this returns."""
        self._append([{"event": event, **entries}])

    def _append(self, lines: Sequence[Mapping[str, object]]) -> None:
        """Append lines, and wait once for the disk."""
        if self.path is None or not lines:
            return
        now = datetime.now(UTC).isoformat(timespec="seconds")
        text = "".join(seal({"time": now, **line}) + "\n" for line in lines)
        try:
            with self.lock, self.path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                # A step that was reported as done must survive a crash of the machine.
                os.fsync(file.fileno())
        except OSError as error:
            raise attach_path(error, self.path) from None

    def step(
        self, kind: str, inputs: Sequence[Any], work: Callable[[], Any], rng: np.random.Generator | None = None
    ) -> Any:
        """Return the result of `work`, from the journal if it is there, else computed and written.

        `inputs` are everything that the result depends on, except the inputs of the whole journal. Inputs and result
        consist of plain numbers, arrays, texts, lists and mappings; tuples are returned as lists. The state of a
        generator from which the work draws is one of the inputs, and its final state is restored.
        """
        if self.path is None:
            return work()
        key = self._key(kind, inputs, rng)
        if found := self._recall(key, rng):
            return found[0]
        began = time.perf_counter()
        with work_counter() as own:
            result = pack(work())
        left = pack(rng.bit_generator.state) if rng else None
        self._append([_step(kind, key, time.perf_counter() - began, own.done, result, left)])
        # The result is unpacked even when it is new, so that resumed and uninterrupted runs see identical types.
        return unpack(result)

    def map_tasks(
        self,
        kind: str,
        function: Callable[[Any], Any],
        tasks: Sequence[Any],
        workers: int,
        on_result: Callable[[Any, Any], None] = lambda task, result: None,
    ) -> list[Any]:
        """Return ``[function(t) for t in tasks]``, each task a step whose only input is the task.

        Known results are taken from the journal. The other tasks are mapped, and written as they end, wherever they
        run. `on_result` is called with each task and its result.
        """
        keys = [self._key(kind, task) if self.path else "" for task in tasks]
        results = {i: found[0] for i, key in enumerate(keys) if (found := self._recall(key))}
        for i, result in results.items():
            on_result(tasks[i], result)
        left = [i for i in range(len(tasks)) if i not in results]

        def note_done(done: Sequence[Done[Any]]) -> None:
            fresh = [(left[n], pack(result) if self.path else result, work, s) for n, (result, work), s in done]
            self._append([_step(kind, keys[i], seconds, work, result) for i, result, work, seconds in fresh])
            for i, result, _, _ in fresh:
                results[i] = unpack(result) if self.path else result
                on_result(tasks[i], results[i])

        map_tasks(partial(count_work, function), [tasks[i] for i in left], workers, note_done)
        return [results[i] for i in range(len(tasks))]

    def _key(self, kind: str, inputs: Any, rng: np.random.Generator | None = None) -> str:
        """Return the key of a step: a digest of everything that its result depends on."""
        return digest([kind, inputs, rng.bit_generator.state if rng else None, self.inputs])

    def _recall(self, key: str, rng: np.random.Generator | None = None) -> tuple[Any] | None:
        """Return the stored result of a step and restore its generator; None if there is no valid value."""
        if key not in self.known:
            return None
        line = self.known[key]
        before: Any = rng.bit_generator.state if rng else None
        try:
            result = unpack(line["result"])
            if rng:
                rng.bit_generator.state = unpack(line["rng"])
        except (
            ArithmeticError,
            AttributeError,
            LookupError,
            TypeError,
            ValueError,
        ):  # an intact line with a foreign value
            if rng:
                # A state that was set before the failure must not leak into the computation that replaces the step.
                rng.bit_generator.state = before
            return None
        self.saved_s += line["seconds"]
        count(line["work"])
        return (result,)


def _step(kind: str, key: str, seconds: float, work: int, result: object, rng: object = None) -> dict[str, object]:
    return {"event": STEP, "step": kind, "key": key, "seconds": seconds, "work": work, "result": result, "rng": rng}


def last_run(path: Path) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return inputs and events of the last run in a journal, both empty if there is none."""
    try:
        lines, _ = read_entries(path, mends=False)
    except (OSError, UsageError):
        return {}, ()
    events = tuple(line["event"] for line in lines)
    if STARTED not in events:
        return {}, ()
    initial = len(events) - 1 - events[::-1].index(STARTED)
    return dict(lines[initial].get("inputs", {})), events[initial:]


def with_version(inputs: Mapping[str, str]) -> dict[str, str]:
    """Return inputs with the version of mechid, as a journal contains them."""
    return {**inputs, VERSION: source_digest()}


def pack(value: Any) -> Any:
    """Return a value in a form that JSON stores to the last bit: floats in hexadecimal."""
    if isinstance(value, np.ndarray):
        return {"shape": list(value.shape), "hex": " ".join(float(x).hex() for x in value.ravel())}
    if isinstance(value, Mapping):
        return {"items": [[key, pack(entry)] for key, entry in value.items()]}
    if isinstance(value, list | tuple):
        return [pack(entry) for entry in value]
    # Hexadecimal, because decimal text would not always restore the last bit; NumPy's double is a float too.
    if isinstance(value, float):
        return {"hex": float(value).hex()}
    if isinstance(value, np.integer | np.bool_):
        return value.item()
    return value


def unpack(value: Any) -> Any:
    """Return the value given to `pack`, with tuples as lists."""
    if isinstance(value, list):
        return [unpack(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    if "items" in value:
        return {key: unpack(entry) for key, entry in value["items"]}
    if "shape" in value:
        return np.array([float.fromhex(x) for x in value["hex"].split()], dtype=np.float64).reshape(value["shape"])
    return float.fromhex(value["hex"])


def digest(value: Any) -> str:
    """Return a digest of plain values and arrays, to the last bit."""
    return hashlib.sha256(json.dumps(pack(value)).encode()).hexdigest()


def _refuse_others(path: Path, found: Mapping[str, str], inputs: Mapping[str, str]) -> None:
    """Raise if a run to be resumed had other inputs."""
    other = sorted(name for name in {*found, *inputs} if found.get(name) != inputs.get(name))
    if other:
        raise UsageError(
            f"{path}: cannot be resumed because its run had other inputs ({', '.join(other)}); "
            "give the same ones, or start again without --resume"
        )
