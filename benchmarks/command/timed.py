"""A command of mechid, timed from within: `timed.py FILE VERB ...` runs it and writes the seconds of its parts.

A part's time is its own, without the parts within it. What is imported before the verb begins is a part as well. CPU
time is this process's; that of the processes that draw figures stands beside the whole, and the report waits for them.
"""

import functools
import importlib
import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

BEGAN = time.time()
PARTS = {
    "records": ("mechid.campaign", "load_campaign"),
    "kernel": ("mechid.cli.kernel_notice", "prepare_kernels"),
    "first sight": ("mechid.identification.identify", "apply_findings"),
    "chaos": ("mechid.identification.identify", "chaos_warnings"),
    "search": ("mechid.identification.run", "search"),
    "multi-start": ("mechid.identification.stages.start_growth", "multistart"),
    "errors": ("mechid.identification.identify", "conclude"),
    "validation": ("mechid.reports.into_folder", "validate"),
    "results": ("mechid.reports.into_folder", "write_results"),
    "curves": ("mechid.reports.illustration", "record_curves"),
    "contents": ("mechid.reports.files", "report_contents"),
    "page": ("mechid.reports.files", "write_together"),
    "equations": ("mechid.reports.files", "equations_mathml"),
    "terminal": ("mechid.ink.presenter", "print_document"),
    "declarations": ("mechid.checks.run", "declaration_warnings"),
    "starts and chaos": ("mechid.checks.run", "start_warnings"),
}
"""Name of a part -> module and name of the function that does it."""
LATE = {"mechid.reports.files"}
"""Modules that a command imports only when it comes to them."""
EARLY = {
    "identify": ("mechid.campaign", "mechid.cli.kernel_notice", "mechid.cli.identification"),
    "check": ("mechid.campaign", "mechid.cli.kernel_notice", "mechid.checks.run"),
    "look": ("mechid.looks.run",),
    "diagnose": ("mechid.fits.load", "mechid.diagnoses.run"),
    "budget": ("mechid.budgets.run",),
    "compare": ("mechid.comparisons.run",),
}
"""Name of a command -> modules that it imports before its work."""

Seconds = dict[str, float]
spent: dict[str, Seconds] = {}
within: list[Seconds] = []


def main() -> None:
    """Run the command, and write its times whatever its exit code."""
    out, *command = sys.argv[1:]
    sys.argv = ["mechid", *command]
    wall = time.time() - _process_start()
    try:
        app = _prepared(command[0])
        _note("imports", {"wall_s": wall + time.time() - BEGAN, "cpu_s": time.process_time()})
        app()
    finally:
        pens = resource.getrusage(resource.RUSAGE_CHILDREN)
        whole = {
            "wall_s": time.time() - _process_start(),
            "cpu_s": time.process_time(),
            "figures_cpu_s": pens.ru_utime + pens.ru_stime,
        }
        Path(out).write_text(json.dumps({"whole": whole, "parts": spent}))


def _process_start() -> float:
    """Return when this process began, s since 1970."""
    fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    boot = next(line for line in Path("/proc/stat").read_text().splitlines() if line.startswith("btime"))
    return float(boot.split()[1]) + float(fields[19]) / 100.0


def _prepared(verb: str) -> Callable[[], None]:
    """Import what the verb imports first, and put a clock around each of its parts."""
    app = importlib.import_module("mechid.cli.app")
    for name in EARLY.get(verb, ()):
        importlib.import_module(name)
    for part, (module, name) in PARTS.items():
        if module in sys.modules and module not in LATE:
            _clock(part, module, name)
    if "mechid.cli.identification" in sys.modules:
        _clock_late()
    return app.main


def _clock(part: str, module: str, name: str) -> None:
    found = sys.modules[module]
    setattr(found, name, _timed(part, getattr(found, name)))


def _clock_late() -> None:
    """Put clocks around the parts of the report once that has been imported, within the report's own time."""
    identified = sys.modules["mechid.reports.into_folder"]
    report = identified._report

    def with_clocks(*arguments: object, **named: object) -> object:
        for module in LATE:
            importlib.import_module(module)
        for part, (module, name) in PARTS.items():
            if module in LATE:
                _clock(part, module, name)
        return report(*arguments, **named)

    identified._report = _timed("report", with_clocks)


def _timed(part: str, function: Callable) -> Callable:
    @functools.wraps(function)
    def run(*arguments: object, **named: object) -> object:
        wall, cpu = time.time(), time.process_time()
        inner = {"wall_s": 0.0, "cpu_s": 0.0}
        within.append(inner)
        try:
            return function(*arguments, **named)
        finally:
            within.pop()
            took = {"wall_s": time.time() - wall, "cpu_s": time.process_time() - cpu}
            _note(part, {key: took[key] - inner[key] for key in took})
            for key in took if within else ():
                within[-1][key] += took[key]

    return run


def _note(part: str, took: Seconds) -> None:
    before = spent.setdefault(part, {"wall_s": 0.0, "cpu_s": 0.0})
    spent[part] = {key: before[key] + took[key] for key in took}


if __name__ == "__main__":
    main()
