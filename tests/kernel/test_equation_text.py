"""The equations as a reader gets them; truth: the plant's own expressions, read back from the text."""

import html
import re
from xml.etree import ElementTree

import pytest
import sympy as sp
from sympy.printing.mathml import mathml

from mechid.kernel.equation_text import (
    LATEX,
    MATHML,
    equations_latex,
    equations_mathml,
    equations_text,
    equations_with,
)
from mechid.plant.assembly import stepper_gear_mass

PLANT = stepper_gear_mass((4, 2), "paper")
NAMES = {
    str(s): s for e in (*(e for _, e in PLANT.terms), *PLANT.rates, *PLANT.outputs.values()) for s in e.free_symbols
}


def section(title):
    """Return the lines of a section as {left: right}."""
    blocks = equations_text(PLANT).split("\n\n")
    lines = next(block for block in blocks if block.splitlines()[0] == title).splitlines()[1:]
    return {left.strip(): right.strip() for left, _, right in (line.partition(" = ") for line in lines)}


def test_terms_and_rates_read_back_to_the_plants_own():
    terms = {str(s): e for s, e in PLANT.terms}
    assert {k: sp.sympify(v, locals=NAMES) for k, v in section("Terms").items()} == terms
    rates = {f"d{s}/dt": e for s, e in zip(PLANT.states, PLANT.rates, strict=True)}
    assert {k: sp.sympify(v, locals=NAMES) for k, v in section("Rates").items()} == rates


def test_every_parameter_is_named_with_unit_and_meaning():
    text = equations_text(PLANT)
    for name, declaration in PLANT.declarations.items():
        assert f"{name} [{declaration.unit}], {declaration.meaning}" in text


def test_a_rigid_housing_has_no_linear_part():
    assert "linear part" in equations_text(PLANT)
    assert "linear part" not in equations_text(stepper_gear_mass((4,), None))


def test_latex_is_balanced_and_sets_words_upright():
    text = equations_latex(PLANT)
    assert text.count(r"\begin{align*}") == text.count(r"\end{align*}") == 7
    assert text.count("{") == text.count("}")
    assert r"T_{fr} &= T_{frd} \sigma + T_{visc} \omega" in text
    assert r"\mathrm{free}" in text
    assert r"\mathrm{alpha}" not in text


def test_mathml_is_well_formed_and_has_a_line_for_each_of_the_text():
    """Truth: the sections of the plain text; an XML parser."""
    sections = equations_mathml(PLANT)
    plain = equations_text(PLANT).split("\n\n")
    lines = {block.splitlines()[0]: len(block.splitlines()) - 1 for block in plain}
    assert {s.title: len(s.lines) for s in sections} == {t: n for t, n in lines.items() if n and t != "Parameters"}
    for section in sections:
        for side in (side for line in section.lines for side in line):
            ElementTree.fromstring(f"<math>{html.unescape(side.replace('&gt;', '&amp;gt;'))}</math>")


def test_the_dot_of_a_rate_sits_on_the_letter_not_on_the_index():
    """Truth: MathML's own structure, in which what is over an element is over all of it; LaTeX's likewise."""
    (rates,) = (section for section in equations_mathml(PLANT) if section.title == "Rates")
    lefts = [ElementTree.fromstring(html.unescape(left)) for left, _ in rates.lines]
    indexed = [left for left in lefts if left.tag == "msub"]
    assert len(lefts) == len(PLANT.states)
    assert len(indexed) == sum("_" in str(state) for state in PLANT.states) > 0
    for left in lefts:
        (over,) = list(left.iter("mover"))
        assert [child.tag for child in over] == ["mi", "mo"]
        assert over[1].text == "˙"
    latex = equations_latex(PLANT)
    assert r"\dot{\alpha}_{gear} &= \omega_{gear}" in latex
    assert r"\dot{\omega} &= " in latex


def test_a_state_that_is_a_rate_by_its_name_is_written_with_dots():
    """Truth: what a reader of q_dot_1 writes by hand, and of its rate; of one without a dot nothing changes."""
    q, rate = sp.symbols("q_1 q_dot_1")
    assert MATHML.expression(rate) == MATHML.rate(q).replace("˙", "&#729;")
    assert "¨" in MATHML.rate(rate)
    assert LATEX.expression(3 * rate) == r"3 \dot{q}_{1}"
    assert LATEX.rate(rate) == r"\ddot{q}_{1}"
    for plain in (sp.Symbol("T_rg"), sp.sin(sp.Symbol("alpha_gear")) / 3):
        assert MATHML.expression(plain) == mathml(plain, printer="presentation")


@pytest.mark.parametrize(
    ("name", "stands_in"),
    [("gear.stiffness", ["T_rg"]), ("friction.viscous", ["T_fr"]), ("stepper.coil_resistance", ["i_A", "i_B"])],
)
def test_the_equations_of_a_parameter_are_those_it_stands_in(name, stands_in):
    """Truth: the blocks' pages."""
    lines = equations_with(PLANT, name)
    for left, right in lines:
        ElementTree.fromstring(html.unescape(f"<math><mrow>{left}</mrow><mrow>{right}</mrow></math>"))
    assert [re.sub(r"<[^>]*>|˙|_", "", left) for left, _ in lines] == [side.replace("_", "") for side in stands_in]
