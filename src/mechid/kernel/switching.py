"""Switches of a plant as Python text: margins of guards, their slopes and gradients, entry rules, resets."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from mechid.kernel.physics import Writer, function


def guards(writer: Writer) -> list[str]:
    """Write the margins of all guards by mode, their rates and gradients, entry rules and mode symbols."""
    margins, slopes, gradients, at = [], [], [], writer.at
    for switch in writer.plant.switches:
        for mode in switch.modes:
            expressions = [guard.margin for guard in switch.guards.get(mode, ())]
            margins.append(writer.body([(at.g[i], e) for i, e in enumerate(expressions)]))
            slopes.append(_slope_lines(writer, expressions))
            gradients.append(_gradient_lines(writer, expressions))
    modes = [len(s.modes) for s in writer.plant.switches]
    return [
        *_by_mode(
            "margins",
            "w_, x_at, g_at",
            "Margins of the guards of a mode; it holds while all are positive.",
            margins,
            modes,
        ),
        *_by_mode("slopes", "w_, x_at, k_at, g_at", "Time derivatives of the margins along the flow k.", slopes, modes),
        *_by_mode(
            "gradients",
            "w_, x_at",
            "Gradients of the margins to states and parameters; zeros stand already.",
            gradients,
            modes,
        ),
        _entry(writer),
        _mode_symbols(writer),
        _resets(writer),
    ]


def _slope_lines(writer: Writer, margins: Sequence[sp.Expr]) -> list[str]:
    rates, at = [sp.Symbol(f"k_{i}") for i in range(len(writer.plant.states))], writer.at
    flows = []
    for e in margins:
        g_x = writer.program.partial_x(e)
        flows.append(sp.Add(*(d * k for d, k in zip(g_x, rates, strict=True))))
    read = [f"{k} = {at.k[i]}" for i, k in enumerate(rates) if any(e.has(k) for e in flows)]
    wanted = [(at.g[i], e) for i, e in enumerate(flows)]
    return [*read, *writer.body(wanted, scalars=rates, share=True)]


def _gradient_lines(writer: Writer, margins: Sequence[sp.Expr]) -> list[str]:
    wanted, at = list[tuple[str, sp.Expr]](), writer.at
    for n, e in enumerate(margins):
        g_x, g_p = writer.program.partial_x(e), writer.program.partial_p(e)
        wanted += [(at.g_x[n * len(g_x) + i], d) for i, d in enumerate(g_x) if d != 0]
        wanted += [(at.g_p[n * len(g_p) + i], d) for i, d in enumerate(g_p) if d != 0]
    return writer.body(wanted, share=True)


def _by_mode(name: str, arguments: str, doc: str, bodies: Sequence[Sequence[str]], modes: Sequence[int]) -> list[str]:
    """Write one function that branches by switch and mode; a long body becomes a function of its own."""
    functions, lines = [], []
    places = [(s, mode) for s, count in enumerate(modes) for mode in range(count)]
    for (s, mode), body in zip(places, bodies, strict=True):
        call = body
        if len(body) > 4:
            functions.append(function(f"{name}_{s}_{mode}", arguments, doc, body))
            call = [f"{name}_{s}_{mode}({arguments})"]
        if call:
            lines += [f"if s == {s} and mode == {mode}:", *(f"    {line}" for line in call)]
    return [*functions, function(name, f"s, mode, {arguments}", doc, [*lines, "return"], inline=True)]


def _entry(writer: Writer) -> str:
    lines: list[str] = []
    for i, switch in enumerate(writer.plant.switches):
        modes = list(switch.modes)
        rules = [(f"rule_{n}", e) for n, (e, _) in enumerate(switch.entry)]
        inner = writer.body(rules, share=True)
        for n, (_, mode) in enumerate(switch.entry):
            inner += [f"if rule_{n} > 0.0:", f"    return {modes.index(mode)}"]
        lines += [
            f"if s == {i}:",
            *(f"    {line}" for line in inner),
            f"    return {modes.index(switch.otherwise)}",
        ]
    return function("entry_mode", "s, w_, x_at", "Mode that switch s takes at x.", [*lines, "return 0"], returns="int")


def _mode_symbols(writer: Writer) -> str:
    lines, first, at = [], 0, writer.at
    for i, switch in enumerate(writer.plant.switches):
        for j, values in enumerate(switch.modes.values()):
            lines.append(f"if s == {i} and mode == {j}:")
            lines += [f"    {at.m[first + n]} = {float(v)!r}" for n, v in enumerate(values.values())]
        first += len(next(iter(switch.modes.values())))
    return function("set_mode", "s, mode, w_", "Write the symbols of a mode.", [*lines, "return"])


def _resets(writer: Writer) -> str:
    lines, g, at = [], 0, writer.at
    index = {s: i for i, s in enumerate(writer.plant.states)}
    for switch in writer.plant.switches:
        # In the order of the modes, by which the guards are numbered; a block may declare its guards in another.
        for guard in (guard for mode in switch.modes for guard in switch.guards.get(mode, ())):
            if guard.resets:
                lines.append(f"if g == {g}:")
                for state, v in guard.resets.items():
                    lines += [f"    {at.x[index[state]]} = {float(v)!r}", f"    {at.pinned[index[state]]} = 1"]
            g += 1
    doc = "States that take a fixed value where guard g fires."
    return function("reset_states", "g, w_, x_at", doc, [*lines, "return"])
