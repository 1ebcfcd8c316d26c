"""The hand-written C loop: compiled at the first call, called through ctypes."""

from __future__ import annotations

import ctypes
import os
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import problem as problems
from .problem import Output, Problem, Run

NAME = "C by hand"
REMARK = "RK4 on 6 states split at the edges, housing in closed form, exact switches"

COLUMNS = len(problems.PARAMETERS) + 1
"""Columns of the Jacobian: the parameters and the record's time offset."""

BLOCK = 4096
"""Rows of the Jacobian's reusable block, as a streaming consumer would have them."""

PROCESSOR = os.environ.get("NUMBA_CPU_NAME", "native")
"""Target of the C compiler: the one that Numba compiles for."""

COMPILE = (
    *("gcc", "-O3", f"-march={PROCESSOR}", "-shared", "-fPIC"),
    # -ffast-math but for its finite-math-only, and for its start file, which would switch gradual
    # underflow off in the whole process:
    *("-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros", "-fassociative-math"),
    *("-freciprocal-math", "-fno-tree-slp-vectorize"),  # packing scalars costs more than it saves
)
SWITCHES = 9

_Doubles = ctypes.POINTER(ctypes.c_double)


class Command(ctypes.Structure):
    _fields_ = (
        ("start_angle", ctypes.c_double),
        ("sample_time", ctypes.c_double),
        ("n_samples", ctypes.c_long),
        ("n_substeps", ctypes.c_long),
        ("n_edges", ctypes.c_long),
        ("edge_times", _Doubles),
        ("voltages", _Doubles),
    )


class _Output(ctypes.Structure):
    _fields_ = (
        ("torque", _Doubles),
        ("jacobian", _Doubles),
        ("rows", ctypes.c_long),
        ("final", _Doubles),
    )


class Trajectory(NamedTuple):
    """What a run leaves.

    Attributes
    ----------
    torque : numpy.ndarray
        Measured torque y in N m, shape (n_samples,).
    jacobian : numpy.ndarray or None
        Its last block of rows (the whole of it where it was asked for), shape (rows, 16): the
        columns of `problem.PARAMETERS`, then the time offset.
    final : numpy.ndarray
        i_A, i_B, alpha, omega, alpha_g, omega_g, z, z' at the last sample, shape (8,).
    mode : int
        Sign of the rotor's speed at the last sample, 0 where it sticks.
    switches : int
        Number of stick/slip switches and reversals.
    """

    torque: np.ndarray
    jacobian: np.ndarray | None
    final: np.ndarray
    mode: int
    switches: int


def simulate(
    problem: Problem,
    *,
    n_substeps: int = 1,
    jacobian: bool = False,
    block_rows: int | None = BLOCK,
    estimated: np.ndarray | None = None,
) -> Trajectory:
    """Run the loop.

    Parameters
    ----------
    problem : Problem
        What to simulate.
    n_substeps : int
        Runge-Kutta steps a sample; one more for each step edge.
    jacobian : bool
        Whether the sensitivities ride along.
    block_rows : int or None
        Rows of the block that the Jacobian is written to over and over; None keeps all of it.
    estimated : numpy.ndarray or None
        Other values of `problem.PARAMETERS`, shape (15,).

    Raises
    ------
    ArithmeticError
        If the friction chatters or the state leaves the finite numbers.
    """
    library = _library()
    values = problem.mechanism.estimated() if estimated is None else estimated
    plant = np.concatenate([values, problem.mechanism.constants()])
    rows = block_rows or problem.n_samples
    torque, final = np.empty(problem.n_samples), np.empty(10)
    block = np.empty((rows, COLUMNS)) if jacobian else None
    command, output = command_of(problem, n_substeps), _Output(rows=rows)
    output.torque, output.final = pointer(torque), pointer(final)
    if block is not None:
        output.jacobian = pointer(block)
    entry = library.simulate if block is None else library.simulate_with_jacobian
    status = entry(pointer(plant), ctypes.byref(command), ctypes.byref(output))
    if status:
        raise ArithmeticError(f"the C loop stopped with status {status}")
    return Trajectory(torque, block, final[:8], int(final[8]), int(final[SWITCHES]))


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False) -> Run:
    """Return the run over the whole record, the Jacobian streamed through a block."""
    _library()
    rows = None if keep_jacobian else BLOCK

    def run() -> Output:
        found = simulate(problem, jacobian=jacobian, block_rows=rows)
        return Output(found.torque, jacobian=found.jacobian[:, :-1] if keep_jacobian else None)

    return run


def truth(problem: Problem, *, jacobian: bool = False) -> Trajectory:
    """Return the run at 64 steps a sample; the benchmark holds it against SciPy's DOP853."""
    return simulate(problem, n_substeps=64, jacobian=jacobian, block_rows=None)


def command_of(problem: Problem, n_substeps: int) -> Command:
    """Return the record's command as the C programs of the benchmarks take it."""
    # ctypes keeps no reference to the arrays: the structure does.
    times, voltages = np.ascontiguousarray(problem.edge_times), problem.voltages
    command = Command(problem.start_angle, problems.SAMPLE_TIME, problem.n_samples, n_substeps)
    command.n_edges, command.arrays = len(times), (times, voltages)
    command.edge_times, command.voltages = pointer(times), pointer(voltages)
    return command


def pointer(array: np.ndarray) -> ctypes._Pointer:
    """Return a pointer to an array of doubles."""
    return array.ctypes.data_as(_Doubles)


@cache
def _library() -> ctypes.CDLL:
    source = Path(__file__).with_name("reference.c")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "reference.so"
        subprocess.run([*COMPILE, "-o", str(target), str(source), "-lm"], check=True)
        return ctypes.CDLL(str(target))
