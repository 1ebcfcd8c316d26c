"""The journal of a long computation: what has been worked out, on disk, so that a killed run goes on from there.

A step is a pure function of its inputs. Its result is noted under their digest, to the last bit, before the next
step begins; a resumed run goes the same way again and takes from the journal what is there. So it ends with the
numbers of an undisturbed run, wherever that was killed, and repeats at most the step that was at work.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import Any, Self

import numpy as np

from mechid.errors import UsageError
from mechid.identification.computation.entries import STARTED, STEP, entries_of, sealed
from mechid.identification.computation.installation import source_digest
from mechid.identification.computation.parallel import Done, mapped
from mechid.writing import placed, writable

RESUMED = "resumed"
VERSION = "version of mechid"
"""Of the inputs: other code may go another way."""


class Journal:
    """Results by the digest of what they follow from; one without a file remembers nothing.

    Attributes
    ----------
    saved_s : float
        What the steps taken from the journal took when they were worked out.
    notice : str
        What was found damaged in the file, in a line; empty where nothing was.
    """

    def __init__(
        self, path: Path | None = None, known: Mapping[str, Mapping[str, Any]] | None = None, notice: str = ""
    ) -> None:
        self.path, self.known, self.lock, self.saved_s = path, dict(known or {}), Lock(), 0.0
        self.notice = notice
        self.inputs = ""

    @classmethod
    def opened(cls, path: Path, inputs: Mapping[str, str], *, resume: bool = False, **entries: object) -> Self:
        """Open a journal for a computation from `inputs`, digests by name; its folder is made where it is missing.

        A new run is appended, its first line with `entries` too; a resumed one takes up the last. What a killed
        run left half-written is cut off; a line that is damaged otherwise is left out, and its step done again.

        Raises
        ------
        UsageError
            The file cannot be written, is no journal, or the run to be resumed had other inputs.
        """
        inputs = with_version(inputs)
        with writable(path.parent):
            lines, notice = entries_of(path)
            begun = max((i for i, line in enumerate(lines) if line["event"] == STARTED), default=None)
            if not resume or begun is None:
                journal = cls(path, notice=notice)
                journal.inputs = digest(inputs)
                journal.note(STARTED, **entries, inputs=inputs)
                return journal
            _refuse_others(path, lines[begun].get("inputs", {}), inputs)
            journal = cls(path, {line["key"]: line for line in lines[begun:] if line["event"] == STEP}, notice)
            journal.inputs = digest(inputs)
            journal.note(RESUMED)
        return journal

    def note(self, event: str, **entries: object) -> None:
        """Append a line; when this returns it is on the disk."""
        self._append([{"event": event, **entries}])

    def _append(self, lines: Sequence[Mapping[str, object]]) -> None:
        """Append lines, and wait once for the disk."""
        if self.path is None or not lines:
            return
        now = datetime.now(UTC).isoformat(timespec="seconds")
        text = "".join(sealed({"time": now, **line}) + "\n" for line in lines)
        try:
            with self.lock, self.path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise placed(error, self.path) from None

    def step(
        self, kind: str, inputs: Sequence[Any], work: Callable[[], Any], rng: np.random.Generator | None = None
    ) -> Any:
        """Return the result of `work`, from the journal where it is there, else worked out and noted.

        `inputs` are all that the result depends on beside the inputs of the whole journal. Both are made of plain
        numbers, arrays, texts, lists and mappings; tuples come back as lists. The state of a generator that the
        work draws from is one of the inputs, and the one that it leaves is restored.
        """
        if self.path is None:
            return work()
        key = self._key(kind, inputs, rng)
        if found := self._recalled(key, rng):
            return found[0]
        began = time.perf_counter()
        result = packed(work())
        left = packed(rng.bit_generator.state) if rng else None
        self._append([_step(kind, key, time.perf_counter() - began, result, left)])
        return unpacked(result)

    def mapped(
        self,
        kind: str,
        function: Callable[[Any], Any],
        tasks: Sequence[Any],
        workers: int,
        on_result: Callable[[Any, Any], None] = lambda task, result: None,
    ) -> list[Any]:
        """Return ``[function(t) for t in tasks]``, each task a step of which it is itself the inputs.

        What is in the journal is taken from there; the others are mapped, and noted as they end, wherever that is.
        `on_result` is called with each task and its result.
        """
        keys = [self._key(kind, task) if self.path else "" for task in tasks]
        results = {i: found[0] for i, key in enumerate(keys) if (found := self._recalled(key))}
        for i, result in results.items():
            on_result(tasks[i], result)
        left = [i for i in range(len(tasks)) if i not in results]

        def ended(done: Sequence[Done[Any]]) -> None:
            fresh = [(left[number], packed(result) if self.path else result, s) for number, result, s in done]
            self._append([_step(kind, keys[i], seconds, result) for i, result, seconds in fresh])
            for i, result, _ in fresh:
                results[i] = unpacked(result) if self.path else result
                on_result(tasks[i], results[i])

        mapped(function, [tasks[i] for i in left], workers, ended)
        return [results[i] for i in range(len(tasks))]

    def _key(self, kind: str, inputs: Any, rng: np.random.Generator | None = None) -> str:
        """Return under what a step is noted: a digest of all that its result follows from."""
        return digest([kind, inputs, rng.bit_generator.state if rng else None, self.inputs])

    def _recalled(self, key: str, rng: np.random.Generator | None = None) -> tuple[Any] | None:
        """Return the result of a step that is noted, its generator restored; None where no such value is there."""
        if key not in self.known:
            return None
        line = self.known[key]
        before: Any = rng.bit_generator.state if rng else None
        try:
            result = unpacked(line["result"])
            if rng:
                rng.bit_generator.state = unpacked(line["rng"])
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):  # whole, but no value of ours
            if rng:
                rng.bit_generator.state = before
            return None
        self.saved_s += line["seconds"]
        return (result,)


def _step(kind: str, key: str, seconds: float, result: object, rng: object = None) -> dict[str, object]:
    return {"event": STEP, "step": kind, "key": key, "seconds": seconds, "result": result, "rng": rng}


def last_run(path: Path) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return inputs and events of the last run that a journal tells of, both empty where there is none."""
    try:
        lines, _ = entries_of(path, mends=False)
    except (OSError, UsageError):
        return {}, ()
    events = tuple(line["event"] for line in lines)
    if STARTED not in events:
        return {}, ()
    begun = len(events) - 1 - events[::-1].index(STARTED)
    return dict(lines[begun].get("inputs", {})), events[begun:]


def with_version(inputs: Mapping[str, str]) -> dict[str, str]:
    """Return inputs with the version of mechid, as a journal notes them."""
    return {**inputs, VERSION: source_digest()}


def packed(value: Any) -> Any:
    """Return a value as JSON can hold it, to the last bit: floats in hexadecimal."""
    if isinstance(value, np.ndarray):
        return {"shape": list(value.shape), "hex": " ".join(float(x).hex() for x in value.ravel())}
    if isinstance(value, Mapping):
        return {"items": [[key, packed(entry)] for key, entry in value.items()]}
    if isinstance(value, list | tuple):
        return [packed(entry) for entry in value]
    if isinstance(value, float):  # NumPy's double is one too
        return {"hex": float(value).hex()}
    if isinstance(value, np.integer | np.bool_):
        return value.item()
    return value


def unpacked(value: Any) -> Any:
    """Return what `packed` was given, tuples as lists."""
    if isinstance(value, list):
        return [unpacked(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    if "items" in value:
        return {key: unpacked(entry) for key, entry in value["items"]}
    if "shape" in value:
        return np.array([float.fromhex(x) for x in value["hex"].split()], dtype=np.float64).reshape(value["shape"])
    return float.fromhex(value["hex"])


def digest(value: Any) -> str:
    """Return a digest of plain values and arrays, to the last bit."""
    return hashlib.sha256(json.dumps(packed(value)).encode()).hexdigest()


def _refuse_others(path: Path, found: Mapping[str, str], inputs: Mapping[str, str]) -> None:
    """Refuse to resume a run whose inputs were others."""
    other = sorted(name for name in {*found, *inputs} if found.get(name) != inputs.get(name))
    if other:
        raise UsageError(
            f"{path}: cannot be resumed, its run had other inputs ({', '.join(other)}); "
            "give the same ones, or start anew without --resume"
        )
