"""Target of ``mechid export --to c``: C source, compiled and compared if there is a compiler."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mechid.exports.c.compiler import CompilerError, compile_sources
from mechid.exports.c.source import FILES, Source
from mechid.exports.export import TargetOutput, Verification
from mechid.exports.handover import Handover, Trial
from mechid.exports.option_texts import NO, yes_or_no
from mechid.exports.reference_outputs import ExportedOutput, compare_results, references, sample_rate_hz, substeps
from mechid.exports.stand import read_stand, select_mechanism
from mechid.writing import write_atomically

MOST_POINTS, MOST_ROWS = 256, 4096
"""Most points of a rate profile, as declared in mechanism.h."""
SENSITIVITIES = "sensitivities"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of the C export.

    Parameters
    ----------
    sensitivities : bool
        Whether derivatives with respect to the parameters with a standard error are integrated too.
    stand : bool
        Export the mechanism as on the bench, with housing, transducer and filters, instead of as in flight.
    values : mapping of dotted name to float
        Changed parameter values in the units of the mechanism file, as ``{"load.inertia": 35.0}``.
    """

    sensitivities: bool = False
    stand: bool = False
    values: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Mapping[str, str]) -> Options:
        """Read options from strings, as ``{"sensitivities": "yes", "stand": "yes"}``.

        Raises
        ------
        UsageError
            An option is unknown or has an invalid value.
        """
        stand, values = read_stand(given, [SENSITIVITIES])
        sensitivities = yes_or_no(SENSITIVITIES, given.get(SENSITIVITIES, NO))
        return cls(sensitivities=sensitivities, stand=stand, values=values)


def write_target(handover: Handover, folder: Path, options: Options | None = None) -> TargetOutput:
    """Write mechanism.h, mechanism.c, main.c and CMakeLists.txt, and compare their output with the kernel.

    Raises
    ------
    InputFileError
        A changed value is impossible.
    MechidError
        The output differs from that of the kernel.
    """
    chosen = options or Options()
    changed = replace(handover, mechanism=select_mechanism(handover.mechanism, chosen.values, stand=chosen.stand))
    source = Source(changed, 1.0 / sample_rate_hz(changed), substeps(changed), chosen.sensitivities)
    for name, text in source.files.items():
        write_atomically(folder / name, text)
    words = [f"Functions of the C library in its loop: {', '.join(source.library)}."] if source.library else []
    try:
        found = _check(source, folder)
    except CompilerError as error:
        return TargetOutput(FILES, None, (f"Not compared: {error}.", *words))
    if found is None:
        # Without a comparison the user has to know that the files are unverified.
        words.insert(0, "Not compared: no record is stepped from rest at the rate of the others.")
    return TargetOutput(FILES, found, tuple(words))


def _check(source: Source, folder: Path) -> Verification | None:
    """Compile the source and compare it under the commands of the records."""
    with TemporaryDirectory() as aside:
        program = compile_sources([folder / "mechanism.c", folder / "main.c"], Path(aside) / "mechanism")
        tried = [r for r in references(source.handover) if source.steps and _can_follow(r.trial)]
        results = [_run(program, r.trial, Path(aside)) for r in tried]
        return compare_results(tried, results, "the C text's result")


def _can_follow(trial: Trial) -> bool:
    """Tell whether the compiled program has room for a command."""
    return len(trial.command.rate.times_s) <= MOST_POINTS and len(trial.command.table) <= MOST_ROWS


def _run(program: Path, trial: Trial, folder: Path) -> ExportedOutput:
    """Run the compiled program under a command."""
    command, switches = folder / "command.csv", folder / "switches.csv"
    command.write_text(command_text(trial), encoding="utf-8")
    duration = repr(trial.base.duration_s)
    done = subprocess.run(
        [program, command, duration, switches], capture_output=True, text=True, check=False, timeout=600
    )
    if done.returncode:
        raise CompilerError(f"the compiled program ended with {done.returncode}: {done.stderr.strip()}")
    outputs = np.loadtxt(io.StringIO(done.stdout), delimiter=",", skiprows=1, ndmin=2)[:, 1:]
    text = switches.read_text(encoding="utf-8")
    return ExportedOutput(outputs, np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2) if text else np.zeros((0, 4)))


def command_text(trial: Trial) -> str:
    """Return a command in the format of the compiled program."""
    command = trial.command
    own = (command.start_angle_deg, command.microsteps, int(command.waveform == "square"), command.clock_tick_s)
    points = zip(command.rate.times_s, command.rate.rates, strict=True)
    rows = [(*own, len(command.table)), *command.table, *points]
    lines = ["start_angle_deg,microsteps,square,clock_tick_s,table_rows", *(",".join(map(repr, row)) for row in rows)]
    return "\n".join(lines) + "\n"
