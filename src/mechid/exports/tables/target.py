"""Target of ``mechid export --to tables``: parameters, lines and histories as CSV, XLSX, HDF5 and Nastran cards."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.hdf5 import is_available
from mechid.budgets.steady_state import cut_off
from mechid.exports.export import TargetOutput, Verification
from mechid.exports.forcing import Forcing, estimate_on_base, forcing
from mechid.exports.handover import Handover
from mechid.exports.stepping import choose_rates, steppings
from mechid.exports.tables import csv_file, hdf5, workbook
from mechid.exports.tables.bulk import write_bulk
from mechid.exports.tables.check import DirectComparison, compare_directly, refuse_difference
from mechid.exports.tables.estimate_tables import estimate_tables, provenance_table
from mechid.exports.tables.forcing_tables import forcing_tables
from mechid.exports.tables.history import simulate_history
from mechid.exports.tables.options import Options
from mechid.exports.tables.table import Table, column_table
from mechid.plant.flight import keeps_stand, with_line_filter
from mechid.plant.mechanism import Mechanism

NO_STEPS = "No record is known that a step command drives: there are no lines, no time histories and no Nastran cards."
NO_HDF5 = 'tables.h5 is left out: install h5py, pip install "mechid[formats]".'
NO_ERRORS = "No parameter of it has a standard error: sigma_Nm and bound_Nm count none."
NO_RESIDUALS = (
    "Nothing is known of what the fit left of its records (residual.json): bound_Nm holds the errors of the parameters "
    "and of the model's lines, not lines that the model lacks."
)
AT_TRANSDUCER = (
    "Lines, bands and bounds are of the torque that the transducer shows; as loads on a structure take those of the "
    "mechanism as it flies."
)
LEAST_ALIKE = 1e-3
"""Difference between lines and a direct simulation, relative to the largest line, above which users are warned."""


@dataclass(frozen=True, eq=False)
class _Torque:
    """Torque on the base: estimate of the mechanism, its lines, and the plant and kernel that produced them."""

    estimate: Estimate
    forcings: tuple[Forcing, ...]
    lined: Mechanism
    lanes: int


def write_target(handover: Handover, folder: Path, options: Options | None = None) -> TargetOutput:
    """Write the tables into a folder.

    Parameters
    ----------
    handover : Handover
    folder : Path
    options : Options or None
        None takes the defaults.

    Raises
    ------
    InputFileError
        The companion files of the estimate are damaged or belong to another fit.
    FitError
        The mechanism diverged.
    UsageError
        The folder is not writable, or a file contains other numbers than those written.
    """
    options = options or Options()
    torque = _torque(handover, options)
    directs = (
        tuple(filter(None, (compare_directly(torque.lined, torque.lanes, f) for f in torque.forcings)))
        if torque
        else ()
    )
    words = tuple(_words(torque, directs))
    tables = [*estimate_tables(handover)]
    histories = []
    if torque:
        tables += forcing_tables(torque.forcings, torque.estimate)
        histories = [
            simulate_history(handover.mechanism, torque.lined, torque.lanes, trial) for trial in handover.trials
        ]
    tables.append(provenance_table(handover, words))
    files = _write(handover, (*tables, *histories), folder)
    if torque:
        files.append(write_bulk(torque.forcings, options, handover.provenance, folder))
    return TargetOutput(tuple(files), _check(directs), words)


def _torque(handover: Handover, options: Options) -> _Torque | None:
    """Compute the torque on the base at the chosen rates; None if no step command drives a record."""
    every = steppings(handover.trials)
    if not every:
        return None
    estimate = estimate_on_base(handover, stand=options.stand)
    rates = np.unique(options.rates) if options.rates else choose_rates(estimate.mechanism, every)
    forcings = tuple(forcing(estimate, stepping, rates) for stepping in every)
    lined = with_line_filter(estimate.mechanism, cut_off(forcings[0].mode))
    return _Torque(estimate, forcings, lined, len(estimate.names) + len(lined.plant.states))


def _write(handover: Handover, tables: Sequence[Table], folder: Path) -> list[str]:
    """Write tables, read them back, and return the file names."""
    every = (*tables, column_table(tuple(tables)))
    files = []
    for table in every:
        files.append(csv_file.write_csv(table, folder))
        refuse_difference(Path(files[-1]), table.numeric, csv_file.read_csv(table, folder))
    sheets = [table for table in every if table.fits_sheet]
    files.append(workbook.write_workbook(sheets, folder))
    for table, read in zip(sheets, workbook.read_workbook(sheets, folder), strict=True):
        refuse_difference(Path(files[-1]), table.numeric, read)
    if is_available():
        files.append(hdf5.write_hdf5(every, handover.provenance, folder))
        for table in every:
            refuse_difference(Path(files[-1]), table.numeric, hdf5.read_hdf5(table, folder))
    return files


def _check(directs: Sequence[DirectComparison]) -> Verification | None:
    """Summarise the comparison with direct simulations; None if there are none."""
    if not directs:
        return None
    off = np.concatenate([one.off for one in directs])
    where = ", ".join(f"{one.stepping} at {one.rate:.6g} steps/s" for one in directs)
    against = f"direct simulations from rest ({where}), lines in N m; every number in every table was read back"
    return Verification(against, float(np.abs(off).max()), float(np.sqrt(np.mean(off**2))))


def _words(torque: _Torque | None, directs: Sequence[DirectComparison]) -> Iterator[str]:
    """Yield remarks for the user of the tables."""
    if not is_available():
        yield NO_HDF5
    if torque is None:
        yield NO_STEPS
        return
    if keeps_stand(torque.lined):
        yield AT_TRANSDUCER
    yield from (f"Left on the bench: {name}: {why}." for name, why in torque.estimate.left.items())
    if not torque.estimate.names:
        yield NO_ERRORS
    if torque.estimate.residual is None:
        yield NO_RESIDUALS
    for one in torque.forcings:
        yield from _of_stepping(one)
    for found in directs:
        off = float(np.abs(found.off).max())
        if off > LEAST_ALIKE * found.largest:
            yield (
                f"{found.stepping} at {found.rate:.6g} steps/s: a direct simulation over {found.seconds:.3g} s differs "
                f"by {off:.2g} N m, the largest line is {found.largest:.2g} N m; do not rely on its lines."
            )


def _of_stepping(one: Forcing) -> Iterator[str]:
    rates, name = one.mode.rates, one.stepping.name
    ran = one.stepping.covers(rates).sum()
    span = f"{rates.size} rates from {rates[0]:.6g} to {rates[-1]:.6g}" if rates.size > 1 else f"{rates[0]:.6g}"
    yield (
        f"{name}: {span} steps/s, lines up to {one.mode.highest_hz:.6g} Hz; records of this stepping ran at {ran} of "
        f"{rates.size} (rates.csv: tested)."
    )
    oddities = (
        (np.array([not s.follows for s in one.largest]), "the rotor does not keep up with the command"),
        (np.array([not s.periods for s in one.largest]), "the motion does not repeat, its lines are of a stretch"),
        (np.array([len(s) > 1 for s in one.states]), "several motions are possible, the largest counts"),
    )
    for which, remark in oddities:
        if which.any():
            yield f"{name}: at {_ranges(rates, which)} steps/s {remark}."


def _ranges(rates: FloatArray, which: BoolArray) -> str:
    """Format the selected rates, with neighbours merged to ranges, as ``5 to 23, 46``.

    Examples
    --------
    >>> _ranges(np.array([5.0, 10.0, 20.0, 46.0]), np.array([True, True, False, True]))
    '5 to 10, 46'
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]]).astype(int)))
    ends = zip(rates[edges[::2]], rates[edges[1::2] - 1], strict=True)
    return ", ".join(f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}" for low, high in ends)
