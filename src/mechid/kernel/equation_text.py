"""Equations of a plant for readers, as plain text, LaTeX, or MathML."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

import sympy as sp
from sympy.printing.mathml import MathMLPresentationPrinter

from mechid.plant.block import Switch
from mechid.plant.plant import Plant


@dataclass(frozen=True)
class Section:
    """A heading and its lines, each a left-hand and a right-hand side separated by a sign."""

    title: str
    lines: tuple[tuple[str, str], ...]
    sign: str = "="


@dataclass(frozen=True)
class Style:
    """Format of expressions, time derivatives, initial values, words and relations."""

    expression: Callable[[sp.Basic], str]
    rate: Callable[[sp.Symbol], str]
    initial: str
    word: str
    separator: str = ", "
    equals: str = "{} = {:g}"
    positive: str = "{} > 0"


def _latex(expression: sp.Basic) -> str:
    """Return LaTeX in which a multi-letter word is set upright rather than as a product of its letters."""
    words = {}
    for symbol in expression.free_symbols:
        base, _, index = str(symbol).partition("_")
        # Greek letters are changed by sp.latex; a base that it leaves as it is, is a word.
        if len(base) > 1 and str(sp.latex(sp.Symbol(base))) == base:
            words[symbol] = rf"\mathrm{{{base}}}" + (f"_{{{index}}}" if index else "")
        elif _dots(symbol)[1]:
            words[symbol] = _latex_dotted(*_dots(symbol))
    return str(sp.latex(expression, symbol_names=words))


def _latex_dotted(symbol: sp.Symbol, dots: int) -> str:
    """Return a symbol with dots on its letter and the index outside them; dots over both would sit on the index."""
    letter, index_sign, index = _latex(symbol).partition("_")
    return rf"\{'d' * dots}ot{{{letter}}}{index_sign}{index}"


def _latex_rate(symbol: sp.Symbol) -> str:
    plain, dots = _dots(symbol)
    return _latex_dotted(plain, dots + 1)


class _Presentation(MathMLPresentationPrinter):
    """SymPy's MathML printer, which prints a rate state such as ``q_dot_1`` as a letter with a dot."""

    def _print_Symbol(self, symbol: sp.Symbol, style: str = "plain") -> Any:
        plain, dots = _dots(symbol)
        return self.add_dots(plain, dots) if dots else super()._print_Symbol(symbol, style)

    def add_dots(self, symbol: sp.Symbol, dots: int) -> Any:
        """Return a symbol with dots on its letter and the index outside them; accents would touch the letter."""
        whole = self._print_Symbol(symbol)
        index = whole.lastChild if whole.tagName == "msub" else None
        mark, over = self.dom.createElement("mo"), self.dom.createElement("mover")
        mark.appendChild(self.dom.createTextNode(DOTS[dots]))
        over.appendChild(whole if index is None else whole.firstChild)
        over.appendChild(mark)
        if index is None:
            return over
        whole.insertBefore(over, index)
        return whole


def _mathml(expression: sp.Basic) -> str:
    return str(_Presentation().doprint(expression))


def _mathml_rate(symbol: sp.Symbol) -> str:
    plain, dots = _dots(symbol)
    return str(_Presentation().add_dots(plain, dots + 1).toxml())


def _dots(symbol: sp.Symbol) -> tuple[sp.Symbol, int]:
    """Return a symbol without the dots in its name, and the number of dots.

    Examples
    --------
    >>> _dots(sp.Symbol("q_dot_1")), _dots(sp.Symbol("alpha_gear"))
    ((q_1, 1), (alpha_gear, 0))
    """
    parts = str(symbol).split("_")
    plain = [part for k, part in enumerate(parts) if k == 0 or part != "dot"]
    return sp.Symbol("_".join(plain)), len(parts) - len(plain)


DOTS = ("", "˙", "¨")
"""Marks over the letter of a first and of a second time derivative."""
TEXT = Style(sp.sstr, "d{}/dt".format, "{}(0)", "{}")
LATEX = Style(_latex, _latex_rate, "{}(0)", r"\text{{{}}}", r",\ ")
MATHML = Style(
    _mathml,
    _mathml_rate,
    "<mrow>{}<mo>(</mo><mn>0</mn><mo>)</mo></mrow>",
    '<mspace width="0.3em"/><mtext>{}</mtext><mspace width="0.3em"/>',
    '<mo separator="true">,</mo><mspace width="0.4em"/>',
    "<mrow>{}<mo>=</mo><mn>{:g}</mn></mrow>",
    "<mrow>{}<mo>&gt;</mo><mn>0</mn></mrow>",
)


def equations_text(plant: Plant) -> str:
    """Return the equations as text, one per line."""
    return "\n\n".join(map(_text_section, [*_sections(plant, TEXT), _parameter_section(plant)])) + "\n"


def equations_latex(plant: Plant) -> str:
    """Return the equations as LaTeX, one ``align*`` per section (package amsmath)."""
    return "\n\n".join(map(_latex_section, _sections(plant, LATEX))) + "\n"


def equations_mathml(plant: Plant) -> tuple[Section, ...]:
    """Return the equations by section, both sides as presentation MathML without the ``math`` element."""
    return tuple(section for section in _sections(plant, MATHML) if section.lines)


def equations_with(plant: Plant, name: str) -> tuple[tuple[str, str], ...]:
    """Return the terms, rates and switch margins that contain a parameter of the file.

    Parameters
    ----------
    plant : Plant
    name : str
        Dotted name of one of the plant's declarations.

    Returns
    -------
    tuple of (str, str)
        Left and right sides as presentation MathML without the ``math`` element.
    """
    own = sp.Symbol(plant.declarations[name].symbol)
    symbols = {s for s, e in plant.coordinates.items() if own in e.free_symbols}
    sides = [(_mathml(s), e) for s, e in plant.terms]
    rates = [*zip(plant.states, plant.rates, strict=True), *_filter_rates(plant)]
    sides += [(MATHML.rate(s), e) for s, e in rates]
    guards = [(switch.name, g) for switch in plant.switches for held in switch.guards.values() for g in held]
    sides += [(MATHML.word.format(escape(f"margin of {switch}")), g.margin) for switch, g in guards]
    return tuple((left, _mathml(e)) for left, e in sides if symbols & e.free_symbols)


def _filter_rates(plant: Plant) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the rates of the linear filter behind the plant."""
    filtered = plant.filter
    if not filtered.states:
        return []
    flow = filtered.A * sp.Matrix(filtered.states) + filtered.B * sp.Matrix(filtered.inputs)
    return list(zip(filtered.states, flow, strict=True))


def _sections(plant: Plant, style: Style) -> Iterator[Section]:
    show = style.expression
    yield Section("Terms", tuple((show(s), show(e)) for s, e in plant.terms))
    yield Section("Rates", tuple(_rates(zip(plant.states, plant.rates, strict=True), style)))
    if plant.filter.states:
        flow = tuple(_rates(_filter_rates(plant), style))
        yield Section("Rates of the linear part, solved in closed form", flow)
    yield Section("Measured", tuple((style.word.format(q), show(e)) for q, e in plant.outputs.items()))
    for switch in plant.switches:
        yield Section(f"Modes of {switch.name}", tuple(_modes(switch, style)), ":")
    starts = zip(plant.states, plant.initial, strict=True)
    yield Section("Start", tuple((style.initial.format(show(s)), show(e)) for s, e in starts))
    own = {s: e for s, e in plant.coordinates.items() if s != e}
    yield Section("From the values of the file", tuple((show(s), show(e)) for s, e in own.items()))


def _rates(pairs: Iterable[tuple[sp.Symbol, sp.Expr]], style: Style) -> Iterator[tuple[str, str]]:
    for state, rate in pairs:
        yield style.rate(state), style.expression(rate)


def _modes(switch: Switch, style: Style) -> Iterator[tuple[str, str]]:
    """Yield each mode with the values that it sets and the condition under which it persists."""
    for mode, values in switch.modes.items():
        held = [style.equals.format(style.expression(s), v) for s, v in values.items()]
        margins = [style.positive.format(style.expression(g.margin)) for g in switch.guards.get(mode, ())]
        until = style.word.format(" while ") + style.separator.join(margins) if margins else ""
        yield style.word.format(mode), style.separator.join(held) + until


def _parameter_section(plant: Plant) -> Section:
    """Return the section with the meanings of the file's symbols."""
    return Section(
        "Parameters",
        tuple((d.symbol, f"{name} [{d.unit}], {d.meaning}") for name, d in plant.declarations.items()),
        ":",
    )


def _text_section(section: Section) -> str:
    width = max((len(left) for left, _ in section.lines), default=0)
    return "\n".join([section.title, *(f"  {left:<{width}} {section.sign} {right}" for left, right in section.lines)])


def _latex_section(section: Section) -> str:
    rows = " \\\\\n".join(f"  {left} &{section.sign} {right}" for left, right in section.lines)
    return f"% {section.title}\n\\begin{{align*}}\n{rows}\n\\end{{align*}}"
