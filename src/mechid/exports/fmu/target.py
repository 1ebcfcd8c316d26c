"""Target of ``mechid export --to fmu``: both FMI versions, with a binary and a comparison if there is a compiler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.exports.export import TargetOutput, Verification
from mechid.exports.fmu.importer import Importer
from mechid.exports.fmu.options import Options
from mechid.exports.fmu.unit import VERSIONS, Unit, with_ports, without_ports
from mechid.exports.fmu.variables import POINTS
from mechid.exports.handover import Handover
from mechid.exports.reference_outputs import ExportedOutput, Reference, compare_results, references

STEP_S = 0.01
"""Communication step in the comparison of a unit, in s."""
MOVING_BASE = "Its base may turn, by the inputs base_acceleration, base_rate and base_angle."


def write_target(handover: Handover, folder: Path, options: Options | None = None) -> TargetOutput:
    """Write `<name>_fmi2.fmu` and `<name>_fmi3.fmu`, and compare their output with the kernel.

    Raises
    ------
    InputFileError
        No step command drives the mechanism, or a changed value is impossible.
    MechidError
        The output of a unit differs from that of the kernel.
    """
    chosen = options or Options()
    at_rest = replace(handover, mechanism=without_ports(handover, chosen.values, stand=chosen.stand))
    whole = replace(at_rest, mechanism=with_ports(at_rest.mechanism, stand=chosen.stand))
    unit = Unit(whole, max((trial.base.duration_s for trial in handover.trials), default=1.0))
    files = {version: f"{handover.name}_fmi{version}.fmu" for version in VERSIONS}
    missing = [unit.write(version, folder / name) for version, name in files.items()]
    words = [] if chosen.stand else [MOVING_BASE]
    if missing[0] is not None:
        return TargetOutput(tuple(files.values()), None, (f"Without binary, not compared: {missing[0]}.", *words))
    # Units hold a limited number of points of a rate profile, and take a table's values as their inputs only.
    commands = [(r, r.trial.command) for r in references(at_rest)]
    tried = [r for r, command in commands if len(command.rate.times_s) <= POINTS and not command.table]
    found = [_compare(tried, folder / name, version, unit) for version, name in files.items()]
    return TargetOutput(tuple(files.values()), _worse(found), tuple(words))


def _compare(tried: list[Reference], path: Path, version: str, unit: Unit) -> Verification | None:
    """Compare a unit at its communication points with the kernel."""
    count = len(unit.handover.mechanism.plant.outputs)
    thinned, results = [], []
    with Importer(path, version, unit.guid) as importer:
        for reference in tried:
            base = reference.trial.base
            rows = np.arange(0, base.samples, max(round(STEP_S * base.sample_rate_hz), 1))
            steps = np.diff(rows) / base.sample_rate_hz
            results.append(ExportedOutput(importer.outputs(reference.trial, steps, count)))
            # The reference is reduced to the communication points of the unit.
            thinned.append(replace(reference, outputs=reference.outputs[rows]))
    return compare_results(thinned, results, f"the torque of the unit for FMI {version}.0")


def _worse(found: list[Verification | None]) -> Verification | None:
    both = [one for one in found if one is not None]
    if not both:
        return None
    worst = max(both, key=lambda one: one.largest_error)
    return replace(worst, against=f"{worst.against}; both units, every {STEP_S:g} s")
