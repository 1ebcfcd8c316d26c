"""Blocks wired into a plant. Truth: small blocks whose equations are written out, and what cannot be wired."""

from dataclasses import replace

import pytest
import sympy as sp

from mechid.campaign import catalogue_mechanism
from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.plant import assemble

x, v, F, k, m = sp.symbols("x v F k m")
SPRING = Block(
    name="spring",
    table="spring",
    declarations=(Declaration("stiffness", "k", "N/m", "stiffness"),),
    inputs=(x,),
    outputs={"force": -k * x},
)
MASS = Block(
    name="mass",
    table="mass",
    declarations=(Declaration("mass", "m", "kg", "mass"),),
    inputs=(F,),
    rates={x: v, v: F / m},
    initial={x: sp.Integer(1), v: sp.Integer(0)},
    outputs={"x": x},
)
WIRING = {"mass.F": "spring.force", "spring.x": "mass.x"}


def oscillator(*blocks, wiring=WIRING):
    return assemble("oscillator", blocks or (SPRING, MASS), wiring, {"position": "mass.x", "force": "spring.force"})


def test_a_spring_and_a_mass_are_an_oscillator():
    """Truth: x' = v, v' = -k x/m, typed by hand."""
    plant = oscillator()
    assert plant.states == (x, v)
    assert [sp.simplify(plant.expand(rate)) for rate in plant.rates] == [v, -k * x / m]
    assert plant.initial == (1, 0)
    assert plant.outputs == {"position": x}
    assert set(plant.parameters) == {k, m}
    assert list(plant.declarations) == ["spring.stiffness", "mass.mass"]


def test_what_is_measured_is_no_part_of_the_motion():
    """Truth: the offered outputs; rates and states stay."""
    plant = oscillator()
    other = plant.with_outputs(("force", "position"))
    assert list(other.outputs) == ["force", "position"]
    assert plant.expand(other.outputs["force"]) == -k * x
    assert (other.states, other.rates) == (plant.states, plant.rates)
    assert other != plant


def test_plants_are_equal_by_their_equations_alone():
    """Truth: the digest; a name or a meaning changes nothing, an equation does."""
    renamed = replace(MASS, declarations=(Declaration("mass", "m", "kg", "what moves"),))
    assert oscillator(SPRING, renamed) == oscillator()
    heavier = replace(MASS, rates={x: v, v: F / (2 * m)})
    assert oscillator(SPRING, heavier) != oscillator()


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        ((replace(SPRING, outputs={"force": -k * x + sp.Symbol("q")}), MASS), "q is no state, term, input"),
        ((SPRING, MASS, replace(MASS, name="other", inputs=())), "two blocks have a state or term x"),
    ],
)
def test_what_cannot_be_wired_is_refused(blocks, said):
    with pytest.raises(ValueError, match=said):
        oscillator(*blocks)


def test_relations_are_given_by_dotted_names():
    """Truth: the declarations of friction and motor."""
    plant = catalogue_mechanism().plant
    assert plant.related_parameters("above") == {"friction.static": "friction.coulomb"}
    assert plant.related_parameters("tied_to")["stepper.back_emf_constant"] == "stepper.torque_constant"
    assert "stepper.poles" not in {str(s) for s in plant.estimable}
    assert plant.of_record["peak_voltage"] == "stepper.peak_voltage"
