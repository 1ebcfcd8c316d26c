"""Runge-Kutta step of a plant as Python text."""

from __future__ import annotations

import sympy as sp

from mechid.kernel.expressions import python_text
from mechid.kernel.physics import Writer, function


def turns(writer: Writer) -> str:
    """Write the sines and cosines of the base angles of a point, computed from its states."""
    first, at = len(writer.plant.states), writer.at
    angles = [(f"turn_{k}", writer.constants.hoist(base)) for k, base in enumerate(writer.angles.bases)]
    lines = writer.expression_loads([e for _, e in angles]) + [f"{name} = {python_text(e)}" for name, e in angles]
    lines += [
        f"{at.x[first + 2 * k]}, {at.x[first + 2 * k + 1]} = sine_and_cosine(turn_{k})" for k in range(len(angles))
    ]
    return function("turn", "w_, x_at", "Complete a point from its states.", [*lines, "return"])


def step(writer: Writer) -> str:
    """Write one classical Runge-Kutta step with known first rates; unrolled, since branches in a loop cost time."""
    states, n_fed, at = writer.plant.states, len(writer.program.filter_inputs), writer.at
    pairs, n_point = writer.angles.pairs, len(writer.point)
    arguments = ", ".join([f"at_{s}" for s in writer.point] + writer.held_arguments)
    lines = [f"{s} = {at.x[i]}" for i, s in enumerate((*states, *pairs))]
    lines += [f"{s} = {at.c[k]}" for k, s in writer.constants.used_in(_increments(writer))]
    lines += [f"k_{s}_0 = {at.k[i]}" for i, s in enumerate(states)]
    lines += ["half, sixth = 0.5 * h, h * (1.0 / 6.0)"]
    for stage, reach in enumerate(("half", "half", "h")):
        lines += [f"at_{s} = {s} + {reach} * k_{s}_{stage}" for s in states]
        # Rotating sine and cosine by the small increment is cheaper than evaluating them anew, to 1e-15.
        lines += _rotation_lines(writer, reach, f"k_{{}}_{stage}")
        lines += [f"{at.points[stage * n_point + i]} = at_{s}" for i, s in enumerate(writer.point)]
        results = [f"k_{s}_{stage + 1}" for s in states] + [f"v_{j}_{stage + 1}" for j in range(n_fed)]
        lines.append(f"{', '.join(results)} = rates_of({arguments}, w_)")
    # The last rate is added last, so that the chain of operations waits for it alone.
    lines += [f"sum_{s} = (k_{s}_0 + 2.0 * (k_{s}_1 + k_{s}_2)) + k_{s}_3" for s in states]
    lines += [f"at_{s} = {s} + sixth * sum_{s}" for s in states]
    lines += _rotation_lines(writer, "sixth", "sum_{}")
    for i, s in enumerate(writer.point):
        lines += [f"{at.new[i]} = at_{s}", f"{at.points[3 * n_point + i]} = at_{s}"]
    # A midpoint of fourth order; the mean of the two inner stages would be of third order.
    lines += [f"{at.mid[j]} = 0.5 * (v_{j}_1 + v_{j}_2) + 0.25 * v_{j}_3" for j in range(n_fed)]
    doc = (
        "From x_at, whose rates are at k_at, one step of length h to new_at; filter inputs half way to mid_at, "
        "the points of the stages and of the end to AT_POINTS."
    )
    return function("step", "w_, x_at, k_at, h, new_at, mid_at", doc, lines, inline=True)


def _increments(writer: Writer) -> list[sp.Expr]:
    """Return the rates of the base angles; a base is linear in the states."""
    return [writer.constants.hoist(base) for base in writer.angles.bases]


def _rotation_lines(writer: Writer, factor: str, rate_name: str) -> list[str]:
    """Return the lines that rotate each sine-cosine pair from the step's start by its rate times a factor."""
    rate_names = {s: sp.Symbol(rate_name.format(s)) for s in writer.plant.states}
    lines = []
    for k, rate in enumerate(_increments(writer)):
        sine, cosine = writer.angles.pair(k)
        text = python_text(rate.xreplace(rate_names))
        lines.append(f"at_{sine}, at_{cosine} = turned({sine}, {cosine}, {factor} * ({text}))")
    return lines
