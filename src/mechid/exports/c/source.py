"""C source of a mechanism: its kernel, its values, and the interface around the kernel."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from string import Template

import sympy as sp

from mechid.exports.handover import Handover
from mechid.kernel.c.module import Module, fold_zeros, module_of
from mechid.kernel.c.printer import WIDTH, Printer
from mechid.kernel.expressions import python_text
from mechid.kernel.physics import function
from mechid.kernel.source import generate, text_of_loop, whole_groups
from mechid.plant.mechanism import Mechanism
from mechid.plant.phases import STAR
from mechid.plant.plant import Plant
from mechid.plant.pulses import HOLD, ON
from mechid.simulation.simulator import CLOSE_STEPS

FILES = ("mechanism.h", "mechanism.c", "main.c", "CMakeLists.txt")
STEPS = ("e_A", "e_B")
"""Inputs supplied by a step driver."""
MOST_SWITCHES = 1024
# Only some mechanisms need them; sections of the templates are selected accordingly.
OWN = ("larger_int", "sine_of", "cosine_of", "square_root", "sine_and_cosine")
"""Helper functions of the C source."""


@dataclass(frozen=True, eq=False)
class Source:
    """C source of a handover.

    Attributes
    ----------
    handover : Handover
    interval_s : float
        Interval of the grid on which the motion is integrated, in s.
    substeps : int
        Integration steps per interval.
    sensitive : bool
        Whether derivatives with respect to the parameters with a standard error are integrated too.
    """

    handover: Handover
    interval_s: float
    substeps: int
    sensitive: bool = False

    @property
    def plant(self) -> Plant:
        """The plant of the mechanism."""
        return self.handover.mechanism.plant

    @property
    def steps(self) -> bool:
        """Whether a step driver supplies the inputs."""
        return set(STEPS) <= set(map(str, self.plant.inputs))

    @cached_property
    def module(self) -> Module:
        """The kernel, without the parts for sensitivities if these are not requested."""
        lanes = whole_groups(len(self.free)) if self.sensitive else 0
        parts = [text_of_loop("mechid.kernel", "fours"), generate(self.plant, lanes), _of_file(self.handover.mechanism)]
        if self.sensitive:
            parts.append(_of_file_slopes(self.handover.mechanism, self.free, lanes))
        return fold_zeros(module_of("\n\n".join(parts)), () if self.sensitive else ("sensitive",))

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters of the mechanism file with a standard error."""
        return tuple(name for name in self.plant.declarations if name in self.handover.names)

    @cached_property
    def files(self) -> dict[str, str]:
        """The sources by file name."""
        return {name: self._fill_template(name) for name in FILES}

    def _fill_template(self, name: str) -> str:
        text = resources.files("mechid.exports.c").joinpath(f"text/{name}.in").read_text(encoding="utf-8")
        needed = {own: own in self._values["kernel"] for own in OWN}
        needed["square_root"] |= self.steps
        return Template(_sections(text, {**self._kinds, **needed})).substitute(self._values)

    @property
    def _kinds(self) -> dict[str, bool]:
        """Which sections of the templates a mechanism has."""
        star, pulse = self.handover.mechanism.phases == STAR, self.handover.mechanism.pulse
        return {
            "steps": self.steps,
            "held": not self.steps,
            "sensitive": self.sensitive,
            "star": star,
            "right_angles": not star,
            "pulsed": pulse is not None,
        }

    @cached_property
    def _values(self) -> Mapping[str, str]:
        printer, plant, constants = Printer(self.module), self.plant, self.module.constants
        own = self.handover.mechanism
        names = list(plant.declarations)
        inputs = list(map(str, plant.inputs))
        library = sorted({"NAN", "sqrt unless MECHANISM_NO_LIBM", *self.library})
        found: dict[str, object] = {
            "title": f"{self.handover.name}: {plant.name}",
            "name": self.handover.name,
            "provenance": "\n".join(f" * {_safe(line)}" for line in self._provenance()),
            "interval": repr(self.interval_s),
            "substeps": f"{self.substeps}.0",
            "close_steps": f"{CLOSE_STEPS}.0",
            "structure": plant.digest[:16],
            "parameters": "\n".join(self._parameters()),
            "n_parameters": len(names),
            "outputs": _entries("Y", plant.outputs),
            "n_outputs": len(plant.outputs),
            "inputs": _entries("U", inputs),
            "n_inputs": len(inputs),
            "inputs_held": max(len(inputs), 1),
            "states": ", ".join(map(str, plant.states)),
            "n_states": len(plant.states),
            "modes": self._modes() or "it has none",
            "size": constants["SIZE"],
            "discrete": constants["DISCRETE"],
            "events": MOST_SWITCHES * (constants["EVENT_LANES"] + constants["NL"]),
            "most_switches": MOST_SWITCHES,
            "columns_free": _entries("D", self.free),
            "n_free": len(self.free),
            "lanes": constants["NL"],
            "full_steps": f"{own.full_steps}.0",
            "n_kernel": len(plant.parameters),
            "pulse_s": f"m->value[MECHANISM_P_{_word(ON)}]",
            "pulse_hold": f"m->value[MECHANISM_P_{_word(HOLD)}]" if HOLD in names else "0.0",
            "library": ", ".join(library),
            "constants": printer.constants(),
            "kernel": printer.text(),
            "run": self._call(printer, "run", _RUN),
            "begin": self._call(printer, "begin", _BEGIN),
            "slopes": self._call(printer, "of_file_slopes", _SLOPES) if self.sensitive else "",
            "values": "\n".join(self._initial()),
            "columns": "".join(f",{q}" for q in plant.outputs),
            **{name: inputs.index(name) if name in inputs else -1 for name in STEPS},
        }
        return {name: str(value) for name, value in found.items()}

    @property
    def library(self) -> tuple[str, ...]:
        """Functions of the C library that the laws of the mechanism need."""
        text = Printer(self.module).text()
        known = ("exp", "log", "tanh", "tan", "atan", "atan2", "pow", "copysign", "hypot")
        return tuple(name for name in known if re.search(rf"\b{name}\(", text))

    def _provenance(self) -> Iterable[str]:
        handed = self.handover.provenance
        yield f"Made by mechid {handed['mechid']} from a fit; do not edit."
        yield from textwrap.wrap(f"{handed['mechanism']} {handed['trust']}", WIDTH)
        fit = handed["fit"]
        for name, digest in fit.get("inputs_sha256", {}).items():
            yield f"{name}: sha256 {digest}"

    def _parameters(self) -> Iterable[str]:
        own = self.handover.mechanism
        for name, declared in self.plant.declarations.items():
            error = self.handover.std_error(name)
            tied = own.parameters[name].tied_to
            status = f"follows {tied}" if tied else f"+- {error:.3g}" if error is not None else "known"
            yield f"    MECHANISM_P_{_word(name)}, /* {name} = {own.value(name):.9g} {declared.unit}, {status} */"

    def _initial(self) -> Iterable[str]:
        own = self.handover.mechanism
        for name in self.plant.declarations:
            yield f"        {own.value(name)!r}, /* {name} */"

    def _modes(self) -> str:
        return "; ".join(
            f"{k} {s.name} ({', '.join(f'{n} {mode}' for n, mode in enumerate(s.modes))})"
            for k, s in enumerate(self.plant.switches)
        )

    def _call(self, printer: Printer, name: str, values: Mapping[str, str]) -> str:
        own = printer.known[name]
        arguments = []
        for argument in own.arguments:
            arguments.append(values[argument])
            if argument in own.counted:
                arguments.append(values[f"{argument}_count"])
        return f"{name}({', '.join(arguments)})"


_RUN = {
    "directions": "m->directions",
    "sensitive": "1",
    "y_dot": "m->y_dot",
    "J": "m->lanes",
    "p": "m->parameter",
    "grid": "grid",
    "edge_times": "m->edge_time",
    "edge_times_count": "m->edges",
    "edge_values": "m->edge_value",
    "discrete": "memory->discrete",
    "w": "memory->w",
    "y": "y",
    "y_count": "count * MECHANISM_OUTPUTS",
    "events": "m->events",
    "events_count": "(int)(sizeof m->events / sizeof(double))",
}
"""C expressions for the arguments of the kernel function `run`."""
_BEGIN = {
    "p": "m->parameter",
    "directions": "m->directions",
    "inputs": "input",
    "theta_0": "command->start_angle_deg * 0.017453292519943295",
    "x_0": "x",
    "x_0_count": "x ? MECHANISM_STATES : 0",
    "x_p": "x",
    "x_p_count": "0",
    "discrete": "m->grid.discrete",
    "w": "m->grid.w",
}
# Slopes that depend on no value lose their argument of the values.
_SLOPES = {"f_": "m->value", "p_": "m->directions"}


def _of_file(mechanism: Mechanism) -> str:
    """Return the function that maps values of the mechanism file to kernel parameters."""
    reads, expressions = _read(mechanism)
    lines = [*reads, *(f"p_[{k}] = {python_text(e)}" for k, e in enumerate(expressions))]
    return function("of_file", "f_, p_", "From values of the mechanism file to the kernel's parameters.", lines)


def _of_file_slopes(mechanism: Mechanism, free: Sequence[str], lanes: int) -> str:
    """Return the function for derivatives of kernel parameters with respect to file values, one lane each."""
    reads, expressions = _read(mechanism)
    places = list(mechanism.plant.declarations)
    lines = [
        f"p_[{k * lanes + lane}] = {python_text(sp.diff(e, sp.Symbol(f'file_{places.index(name)}')))}"
        for k, e in enumerate(expressions)
        for lane, name in enumerate(free)
    ]
    return function(
        "of_file_slopes", "f_, p_", "Derivatives of the kernel's parameters to the file's.", [*reads, *lines]
    )


def _read(mechanism: Mechanism) -> tuple[list[str], list[sp.Expr]]:
    """Return the lines that read the file values, and the kernel parameters as expressions of these.

    A tied parameter reads the value of its master.
    """
    symbols, expressions = mechanism.plant.file_map
    places = {name: k for k, name in enumerate(mechanism.plant.declarations)}
    masters = [places[mechanism.parameters[name].tied_to or name] for name in places]
    renamed = [
        e.xreplace({s: sp.Symbol(f"file_{m}") for s, m in zip(symbols, masters, strict=True)}) for e in expressions
    ]
    used = set().union(*(e.free_symbols for e in renamed), set())
    return [f"file_{k} = f_[{k}]" for k in range(len(places)) if sp.Symbol(f"file_{k}") in used], renamed


def _safe(line: str) -> str:
    """Escape a line so that it does not end its C comment."""
    return line.replace("*/", "* /")


def _entries(kind: str, names: Iterable[str]) -> str:
    """Return the lines of a C enumeration."""
    return "\n".join(f"    MECHANISM_{kind}_{_word(name)}," for name in names)


def _word(name: str) -> str:
    return re.sub(r"\W+", "_", name).upper()


def _sections(text: str, kept: Mapping[str, bool]) -> str:
    """Return a text with only the selected sections; a section is enclosed by ``//{name`` and ``//}name``."""
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
