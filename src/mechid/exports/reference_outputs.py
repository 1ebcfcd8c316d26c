"""Reference outputs of the kernel under the commands of the records, for the verification of exports."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import MechidError
from mechid.exports.export import Verification
from mechid.exports.handover import Handover, Trial
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.trajectory import Switching

DEFAULT_RATE_HZ = 10_000.0
LONGEST_S = 120.0
"""Largest total record time in the comparison."""
TOLERANCE = 1e-9
"""Largest difference between an exported result and mechid, relative to the RMS of the quantity."""
SAME_INSTANT_S = 1e-9


@dataclass(frozen=True, eq=False)
class Reference:
    """Output of the kernel under one command.

    Attributes
    ----------
    name : str
        Name of the record.
    trial : Trial
        Command from time 0 on.
    outputs : (n, n_y)
    switching : Switching
    """

    name: str
    trial: Trial
    outputs: FloatArray
    switching: Switching


def sample_rate_hz(handover: Handover) -> float:
    """Return the most frequent sample rate of the records, that of the integration grid of exports."""
    rates = Counter(trial.base.sample_rate_hz for trial in handover.trials)
    return rates.most_common(1)[0][0] if rates else DEFAULT_RATE_HZ


def substeps(handover: Handover) -> int:
    """Return the integration steps per sample of the fit."""
    own = handover.fit.provenance.get("substeps", 1)
    return own if isinstance(own, int) else 1


def references(handover: Handover) -> list[Reference]:
    """Simulate the commands of records at the rate of the grid, in their order.

    Only records that start at rest with their command are used, up to `LONGEST_S` of record time in total.
    """
    rate_hz, left_s = sample_rate_hz(handover), LONGEST_S
    found = []
    for trial in handover.trials:
        # The grid of an export has one rate, and its simulation starts at rest with the command.
        if trial.base.sample_rate_hz != rate_hz or trial.command.start != "commanded" or left_s <= 0.0:
            continue
        base = TimeBase(rate_hz, min(trial.base.samples, round(left_s * rate_hz) + 1))
        left_s -= base.duration_s
        found.append(_reference(handover, Trial(trial.name, trial.command, base)))
    return found


def _reference(handover: Handover, trial: Trial) -> Reference:
    mechanism = handover.mechanism
    simulator = Simulator(mechanism.plant, trial.command, trial.base)
    run = simulator.run(mechanism.kernel_values(), substeps=substeps(handover), events=trial.base.samples)
    done = simulate_run(run)
    return Reference(trial.name, trial, np.column_stack([y[:] for y in done.values.values()]), done.switching)


@dataclass(frozen=True, eq=False)
class ExportedOutput:
    """Output of an exported model under the same command.

    Attributes
    ----------
    outputs : (n, n_y)
    switches : (k, 4) or None
        Time, switch, mode before and after; None if unknown.
    """

    outputs: FloatArray
    switches: FloatArray | None = None


def compare_results(references: list[Reference], results: list[ExportedOutput], subject: str) -> Verification | None:
    """Compare results with the kernel; None if there are no references.

    Raises
    ------
    MechidError
        They differ by more than `TOLERANCE`.
    """
    if not references:
        return None
    largest, squares, samples = 0.0, 0.0, 0
    for reference, found in zip(references, results, strict=True):
        error = found.outputs - reference.outputs
        size = np.sqrt(np.mean(reference.outputs**2, axis=0))
        # Relative to the RMS of each quantity; an output that is 0 throughout is compared absolutely.
        off = np.sqrt(np.mean(error**2, axis=0)) / np.where(size > 0.0, size, 1.0)
        if not np.all(off <= TOLERANCE):
            worst = float(np.max(off)) if np.all(np.isfinite(off)) else float("nan")
            raise MechidError(
                f"{subject} of record {reference.name} differs by {worst:.3g} of the RMS; nothing is written"
            )
        _refuse_other_switches(reference, found, subject)
        largest = max(largest, float(np.abs(error[:, 0]).max()))
        squares, samples = squares + float(np.sum(error[:, 0] ** 2)), samples + len(error)
    names = ", ".join(reference.name for reference in references)
    switches = sum(len(reference.switching.time) for reference in references)
    against = f"mechid's kernel, {samples} samples of {names}, {switches} switches"
    return Verification(against, largest, float(np.sqrt(squares / samples)))


def _refuse_other_switches(reference: Reference, found: ExportedOutput, subject: str) -> None:
    own, other = reference.switching, found.switches
    if other is None:
        return
    sequence = np.column_stack([own.switch, own.before, own.after])
    same = len(other) == len(own.time) and np.array_equal(other[:, 1:].astype(int), sequence)
    if not same or np.abs(other[:, 0] - own.time).max(initial=0.0) > SAME_INSTANT_S:
        raise MechidError(f"{subject} of record {reference.name} switches otherwise than mechid's; nothing is written")
