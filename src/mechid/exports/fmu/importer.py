"""Minimal FMU importer, which runs a unit under a command through its FMI interface."""

from __future__ import annotations

import ctypes as ct
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import MechidError
from mechid.exports.fmu.variables import OUTPUT, RATE_OF_POINT, TIME_OF_POINT
from mechid.exports.handover import Trial

CO_SIMULATION = 1


class Importer:
    """Loaded archive of one FMI version; closing it deletes the folder of its binary.

    Parameters
    ----------
    path : Path
        The archive, with a binary for this machine.
    version : {"2", "3"}
    guid : str
    """

    def __init__(self, path: Path, version: str, guid: str) -> None:
        self.version, self.guid = version, guid.encode()
        self.folder = tempfile.TemporaryDirectory()
        with zipfile.ZipFile(path) as archive:
            binary = next(name for name in archive.namelist() if name.startswith("binaries/"))
            archive.extract(binary, self.folder.name)
        self.library = ct.CDLL(str(Path(self.folder.name) / binary))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.folder.cleanup()

    def outputs(self, trial: Trial, steps: FloatArray, count: int) -> FloatArray:
        """Return all outputs at the start and after communication steps of these lengths, (len(steps) + 1, count)."""
        of = self._instance()
        try:
            self._command(of, trial)
            self._initialise(of)
            rows = [self._read(of, count)]
            now = 0.0
            for step in steps.tolist():
                self._step(of, now, step)
                now += step
                rows.append(self._read(of, count))
        finally:
            free = self._function("FreeInstance", None)
            free(of)
        return np.array(rows)

    def _function(self, name: str, result: Any = ct.c_int) -> Any:
        found = getattr(self.library, f"fmi{self.version}{name}")
        found.restype = result
        return found

    def _instance(self) -> ct.c_void_p:
        nothing = ct.c_void_p(None)
        if self.version == "2":
            calls = (ct.c_void_p * 5)()
            made = self._function("Instantiate", ct.c_void_p)(
                b"checked", ct.c_int(CO_SIMULATION), self.guid, b"", ct.byref(calls), ct.c_int(0), ct.c_int(0)
            )
            # The unit keeps a pointer to the callbacks, so they must not be freed.
            self._calls = calls
        else:
            no = ct.c_bool(False)
            made = self._function("InstantiateCoSimulation", ct.c_void_p)(
                b"checked", self.guid, b"", no, no, no, no, nothing, ct.c_size_t(0), nothing, nothing, nothing
            )
        if not made:
            raise MechidError("the unit cannot be instantiated; nothing is written")
        # ctypes would pass a bare int as a 32-bit C int, which truncates the pointer.
        return ct.c_void_p(made)

    def _command(self, of: ct.c_void_p, trial: Trial) -> None:
        command = trial.command
        whole = {2: command.microsteps, 3: int(command.waveform == "square"), 4: len(command.rate.times_s)}
        real = {5: command.start_angle_deg, 6: command.clock_tick_s}
        real |= {TIME_OF_POINT + k: t for k, t in enumerate(command.rate.times_s)}
        real |= {RATE_OF_POINT + k: r for k, r in enumerate(command.rate.rates)}
        self._set("Integer" if self.version == "2" else "Int32", ct.c_int32, of, whole)
        self._set("Real" if self.version == "2" else "Float64", ct.c_double, of, real)

    def _set(self, kind: str, type_: Any, of: ct.c_void_p, values: dict[int, Any]) -> None:
        n = len(values)
        arguments = [of, (ct.c_uint32 * n)(*values), ct.c_size_t(n), (type_ * n)(*values.values())]
        # FMI 3.0 also takes the number of values, since a variable may be an array.
        self._call(f"Set{kind}", *arguments, *([] if self.version == "2" else [ct.c_size_t(n)]))

    def _initialise(self, of: ct.c_void_p) -> None:
        zero, no = ct.c_double(0.0), ct.c_int(0)
        if self.version == "2":
            self._call("SetupExperiment", of, no, zero, zero, no, zero)
            self._call("EnterInitializationMode", of)
        else:
            self._call("EnterInitializationMode", of, ct.c_bool(False), zero, zero, ct.c_bool(False), zero)
        self._call("ExitInitializationMode", of)

    def _step(self, of: ct.c_void_p, now: float, length: float) -> None:
        from_s, for_s = ct.c_double(now), ct.c_double(length)
        if self.version == "2":
            self._call("DoStep", of, from_s, for_s, ct.c_int(1))
            return
        flags = [ct.byref(ct.c_bool(False)) for _ in range(3)]
        self._call("DoStep", of, from_s, for_s, ct.c_bool(True), *flags, ct.byref(ct.c_double(0.0)))

    def _read(self, of: ct.c_void_p, count: int) -> Sequence[float]:
        numbers, values = (ct.c_uint32 * count)(*range(OUTPUT, OUTPUT + count)), (ct.c_double * count)()
        name, extra = ("GetReal", []) if self.version == "2" else ("GetFloat64", [ct.c_size_t(count)])
        self._call(name, of, numbers, ct.c_size_t(count), values, *extra)
        return list(values)

    def _call(self, name: str, *arguments: Any) -> None:
        status = self._function(name)(*arguments)
        if status:
            raise MechidError(f"fmi{self.version}{name} of the unit answers with status {status}; nothing is written")
