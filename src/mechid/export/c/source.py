"""The C text of a mechanism: its kernel printed, its values, and what calls it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from string import Template

import sympy as sp

from mechid.export.handover import Handover
from mechid.kernel.c.module import Module, module_of, without
from mechid.kernel.c.printer import Printer, wrapped
from mechid.kernel.expressions import python_text
from mechid.kernel.physics import function
from mechid.kernel.source import generate
from mechid.plant.plant import Plant
from mechid.simulation.simulator import CLOSE_STEPS

FILES = ("mechanism.h", "mechanism.c", "main.c", "CMakeLists.txt")
STEPS = ("e_A", "e_B")
"""Inputs that a step driver gives."""
MOST_SWITCHES = 1024
OWN = """\
static double magnitude(double x) { return x < 0.0 ? -x : x; }
static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }
static int smaller_int(int a, int b) { return b < a ? b : a; }
static int larger_int(int a, int b) { return b > a ? b : a; }

/* Largest whole number not above x; 0 where x is no number that could be one. */
static double floor_of(double x)
{
    if (!(magnitude(x) < 4503599627370496.0)) {
        return magnitude(x) <= 1e300 ? x : 0.0;
    }
    const double whole = (double)(long long)x;
    return whole > x ? whole - 1.0 : whole;
}

static double ceiling_of(double x) { return -floor_of(-x); }

static double square_root(double x)
{
#ifdef MECHANISM_NO_LIBM
    double root = x > 1.0 ? x : 1.0;
    for (int k = 0; k < 600 && root > 0.0; k++) {
        const double better = 0.5 * (root + x / root);
        if (better >= root) {
            break;
        }
        root = better;
    }
    return x > 0.0 ? root : 0.0;
#else
    return sqrt(x);
#endif
}
"""


@dataclass(frozen=True, eq=False)
class Source:
    """The C text of what a fit hands on.

    Attributes
    ----------
    handover : Handover
    interval_s : float
        Between two instants of the grid on which the motion is integrated.
    substeps : int
        Integration steps in an interval.
    """

    handover: Handover
    interval_s: float
    substeps: int

    @property
    def plant(self) -> Plant:
        """The plant."""
        return self.handover.mechanism.plant

    @property
    def steps(self) -> bool:
        """Whether a step driver gives its inputs."""
        return set(STEPS) <= set(map(str, self.plant.inputs))

    @cached_property
    def module(self) -> Module:
        """The kernel without what only sensitivities need."""
        return without(module_of(generate(self.plant, 0) + "\n\n" + _of_file(self.plant)), ("sensitive",))

    @cached_property
    def files(self) -> dict[str, str]:
        """The texts by file name."""
        return {name: self._filled(name) for name in FILES}

    def _filled(self, name: str) -> str:
        text = resources.files("mechid.export.c").joinpath(f"text/{name}.in").read_text(encoding="utf-8")
        return Template(_sections(text, {"steps": self.steps, "held": not self.steps})).substitute(self._values)

    @cached_property
    def _values(self) -> Mapping[str, object]:
        printer, plant, constants = Printer(self.module), self.plant, self.module.constants
        names = list(plant.declarations)
        inputs = list(map(str, plant.inputs))
        library = sorted({"NAN", *(["sqrt unless MECHANISM_NO_LIBM"]), *self.library})
        return {
            "title": f"{self.handover.name}: {plant.name}", "name": self.handover.name,
            "provenance": "\n".join(f" * {line}" for line in self._provenance()),
            "interval": repr(self.interval_s), "substeps": f"{self.substeps}.0", "close_steps": f"{CLOSE_STEPS}.0",
            "structure": plant.digest[:16], "parameters": "\n".join(self._parameters()), "n_parameters": len(names),
            "outputs": "\n".join(f"    MECHANISM_Y_{_word(q)}," for q in plant.outputs), "n_outputs": len(plant.outputs),
            "inputs": "\n".join(f"    MECHANISM_U_{_word(u)}," for u in inputs), "n_inputs": len(inputs),
            "inputs_held": max(len(inputs), 1), "states": ", ".join(map(str, plant.states)), "n_states": len(plant.states),
            "modes": self._modes() or "it has none", "size": constants["SIZE"], "discrete": constants["DISCRETE"],
            "events": MOST_SWITCHES * (constants["EVENT_LANES"] + constants["NL"]), "most_switches": MOST_SWITCHES,
            "n_kernel": len(plant.parameters), "library": ", ".join(library), "constants": printer.constants(),
            "own": self._own(printer.text()), "kernel": printer.text(), "run": self._call(printer, "run", _RUN),
            "begin": self._call(printer, "begin", _BEGIN), "values": "\n".join(self._initial()),
            "columns": "".join(f",{q}" for q in plant.outputs),
            **{name: inputs.index(name) if name in inputs else -1 for name in STEPS},
        }  # fmt: skip

    @property
    def library(self) -> tuple[str, ...]:
        """Functions of the C library that the mechanism's laws need."""
        text = Printer(self.module).text()
        known = ("exp", "log", "tanh", "sin", "cos", "tan", "atan", "atan2", "pow", "copysign", "hypot")
        return tuple(name for name in known if re.search(rf"\b{name}\(", text))

    def _own(self, kernel: str) -> str:
        return (
            OWN if "larger_int(" in kernel else "\n".join(line for line in OWN.splitlines() if "larger_int" not in line)
        )

    def _provenance(self) -> Iterable[str]:
        handed = self.handover.provenance
        yield f"Made by mechid {handed['mechid']} from a fit; do not edit."
        yield from wrapped(str(handed["trust"])).splitlines()
        fit = handed["fit"]
        for name, digest in fit.get("inputs_sha256", {}).items():
            yield f"{name}: sha256 {digest}"

    def _parameters(self) -> Iterable[str]:
        own = self.handover.mechanism
        for name, declared in self.plant.declarations.items():
            error = self.handover.std_error(name)
            tied = own.parameters[name].tied_to
            said = f"follows {tied}" if tied else f"+- {error:.3g}" if error is not None else "known"
            yield f"    MECHANISM_P_{_word(name)}, /* {name} = {own.value(name):.9g} {declared.unit}, {said} */"

    def _initial(self) -> Iterable[str]:
        own = self.handover.mechanism
        for name in self.plant.declarations:
            yield f"        {own.value(name)!r}, /* {name} */"

    def _modes(self) -> str:
        return "; ".join(f"{k} {s.name} ({', '.join(f'{n} {mode}' for n, mode in enumerate(s.modes))})"
                         for k, s in enumerate(self.plant.switches))  # fmt: skip

    def _call(self, printer: Printer, name: str, values: Mapping[str, str]) -> str:
        own = printer.known[name]
        arguments = []
        for argument in own.arguments:
            arguments.append(values[argument])
            if argument in own.counted:
                arguments.append(values[f"{argument}_count"])
        return f"{name}({', '.join(arguments)})"


_RUN = {
    "p": "m->parameter", "grid": "grid", "edge_times": "m->edge_time", "edge_times_count": "m->edges",
    "edge_values": "m->edge_value", "discrete": "memory->discrete", "w": "memory->w", "y": "y",
    "y_count": "count * MECHANISM_OUTPUTS", "events": "m->events", "events_count": "(int)(sizeof m->events / sizeof(double))",
}  # fmt: skip
_BEGIN = {
    "p": "m->parameter", "inputs": "input", "theta_0": "command->start_angle_deg * 0.017453292519943295",
    "x_0": "x", "x_0_count": "x ? MECHANISM_STATES : 0", "x_p": "x", "x_p_count": "0",
    "discrete": "m->grid.discrete", "w": "m->grid.w",
}  # fmt: skip


def _of_file(plant: Plant) -> str:
    """Return the function that turns the mechanism file's values into the kernel's parameters."""
    symbols, expressions = plant.file_map
    renamed = {s: sp.Symbol(f"file_{k}") for k, s in enumerate(symbols)}
    used = set().union(*(e.free_symbols for e in expressions), set())
    lines = [f"{renamed[s]} = f_[{k}]" for k, s in enumerate(symbols) if s in used]
    lines += [f"p_[{k}] = {python_text(e.xreplace(renamed))}" for k, e in enumerate(expressions)]
    return function(
        "of_file", "f_, p_", "From the values of the mechanism file to the parameters of the kernel.", lines
    )


def _word(name: str) -> str:
    return re.sub(r"\W+", "_", name).upper()


def _sections(text: str, kept: Mapping[str, bool]) -> str:
    """Return a text with only the sections that are kept; a section stands between ``//{name`` and ``//}name``."""
    lines, dropped = [], 0
    for line in text.splitlines(keepends=True):
        mark = line.strip()
        if mark.startswith("//{"):
            dropped += not kept[mark[3:]] or dropped > 0
        elif mark.startswith("//}"):
            dropped -= dropped > 0
        elif not dropped:
            lines.append(line)
    return "".join(lines)
