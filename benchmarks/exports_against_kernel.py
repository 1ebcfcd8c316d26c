"""How fast the C text and the units run beside the kernel: the 60 s sweep, one after the other, ratios of CPU time.

    python benchmarks/exports_against_kernel.py FIT [--rounds N]

FIT is the result folder of `mechid demo`, or of any fit of a stepper.
"""

import argparse
import subprocess
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.command import Command, RateProfile
from mechid.exports.c.compiler import compile_sources
from mechid.exports.c.source import Source
from mechid.exports.fmu.importer import Importer
from mechid.exports.fmu.unit import VERSIONS, Unit, with_ports, without_ports
from mechid.exports.handover import Trial, handover
from mechid.exports.reference_outputs import sample_rate_hz, substeps
from mechid.exports.run import read_with_campaign
from mechid.simulation.simulator import Simulator, TimeBase

SECONDS = 60.0
SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (SECONDS, 120.0)]))
STEPS_S = (1e-1, 1e-2, 1e-3)
MAIN = """\
#include <stdio.h>
#include <time.h>
#include "mechanism.h"
static mechanism m;
static mechanism_command command = {{0.0, 16, 0, 0.0, 2, {{0.0, {seconds}}}, {{0.0, 120.0}}}};
static double y[MECHANISM_AT_ONCE * MECHANISM_OUTPUTS];
int main(void)
{{
    clock_t began = clock();
    int status = mechanism_init(&m) | mechanism_start(&m, &command, 0);
    for (long left = {samples}; left > 0 && !status; left -= MECHANISM_AT_ONCE) {{
        status = mechanism_sample(&m, left < MECHANISM_AT_ONCE ? (int)left : MECHANISM_AT_ONCE, y);
    }}
    printf("%.9g\\n", (double)(clock() - began) / CLOCKS_PER_SEC);
    return status;
}}
"""


def main() -> None:
    """Print the shortest CPU time of each, and its ratio to the kernel's."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fit", type=Path)
    parser.add_argument("--rounds", type=int, default=10)
    arguments = parser.parse_args()
    what = handover(*read_with_campaign(arguments.fit)[:2])
    with tempfile.TemporaryDirectory() as folder:
        contenders = {"kernel": kernel(what.mechanism), "C text": c_text(what, Path(folder))}
        contenders |= units(what, Path(folder))
        seconds = {name: min(run() for _ in range(arguments.rounds)) for name, run in contenders.items()}
    for name, found in seconds.items():
        print(f"{name:28} {found:8.4f} s   {found / seconds['kernel']:6.2f} of the kernel")


def kernel(mechanism):
    """Return a run of the kernel, which gives its CPU time."""
    simulator = Simulator(mechanism.plant, SWEEP, TimeBase(10_000.0, round(SECONDS * 10_000.0) + 1))

    def run():
        began = time.process_time()
        for _ in simulator.run(mechanism.kernel_values()).blocks():
            pass
        return time.process_time() - began

    run()
    return run


def c_text(what, folder):
    """Return the same of the compile_sources text."""
    source = Source(what, 1.0 / sample_rate_hz(what), substeps(what))
    for name, text in source.files.items():
        (folder / name).write_text(text)
    (folder / "time.c").write_text(MAIN.format(seconds=SECONDS, samples=round(SECONDS * sample_rate_hz(what))))
    program = compile_sources([folder / "mechanism.c", folder / "time.c"], folder / "timed")
    return lambda: float(subprocess.run([program], capture_output=True, text=True, check=True).stdout)


def units(what, folder):
    """Return the same of the units, for each communication step; the importer's own calls count."""
    at_rest = replace(what, mechanism=without_ports(what, {}, stand=True))
    unit = Unit(replace(at_rest, mechanism=with_ports(at_rest.mechanism, stand=True)), SECONDS)
    found = {}
    for version in VERSIONS:
        path = folder / f"{version}.fmu"
        if (problem := unit.write(version, path)) is not None:
            raise SystemExit(str(problem))
        for step_s in STEPS_S:
            found[f"unit FMI {version}.0, {step_s:g} s"] = timed_unit(path, version, unit.guid, step_s)
    return found


def timed_unit(path, version, guid, step_s):
    """Return a run of a unit, which gives its CPU time from instantiation on; the library is loaded before."""
    trial, steps = Trial("sweep", SWEEP, TimeBase(10_000.0, 1)), np.full(round(SECONDS / step_s), step_s)

    def run():
        with Importer(path, version, guid) as importer:
            began = time.process_time()
            importer.outputs(trial, steps, 1)
            return time.process_time() - began

    return run


if __name__ == "__main__":
    main()
