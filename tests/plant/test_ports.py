"""What acts on a mechanism from outside: a torque on its output, what is added in each phase."""

import numpy as np
import pytest

from layouts import LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.kernel.equations import equations_of
from mechid.plant.flight import to_flight, with_base, with_ports
from mechid.plant.layout import Base, Flying
from mechid.plant.moving_base import ACCELERATION
from mechid.plant.ports import Port
from mechid.simulation.linearisation import named_holdings

ALONE = {"assembly": "current_driven_stepper", **SINGLE_STEPPER}
INERTIA = {"paper": 0.010534, "output_friction": 0.010534, "flexible load": 0.010534, "kinematic_error": 0.010534}


def flying(name, base):
    """Return a mechanism in flight with all ports."""
    table = ALONE if name == "alone" else changed(paper_table(), {"housing": None, **LAYOUTS.get(name, {})})
    held = to_flight(mechanism_of(table))
    return with_ports(with_base(held, Flying(base=base)) if base is not Base.HELD else held, list(Port))


def at_random(mechanism, name, holding, *, push, turn):
    """Return states, rates and torque on the base at a random state that the holding allows."""
    plant, rng = mechanism.plant, np.random.default_rng(5)
    x = 1e-2 * rng.normal(size=len(plant.states))
    if name in ("stuck", "locked"):
        x[[str(s) for s in plant.states].index("omega")] = 0.0
    if name == "locked":
        x[[str(s) for s in plant.states].index("omega_gear")] = 0.0
    given = {"e_A": 0.3, "e_B": -0.8, "output_torque": push, ACCELERATION.name: turn}
    inputs = [given.get(s.name, 0.0) for s in plant.inputs]
    equations = equations_of(plant)
    modes = [holding[s] for s in equations.rates.arguments[2]]
    p = mechanism.kernel_values().tolist()
    rates = dict(zip(map(str, plant.states), equations.rates(x.tolist(), inputs, modes, p), strict=True))
    return rates, equations.outputs(x.tolist(), inputs, modes, p)[0]


@pytest.mark.parametrize("base", [Base.HELD, Base.DRIVEN])
@pytest.mark.parametrize("name", ["paper", "output_friction", "flexible load", "alone"])
def test_angular_momentum(name, base):
    """Truth: base and outside exert the rate of all bodies' angular momentum, whatever friction does."""
    mechanism = flying(name, base)
    turn = 3.0 if base is Base.DRIVEN else 0.0
    for holds, holding in named_holdings(mechanism.plant).items():
        rates, torque = at_random(mechanism, holds, holding, push=0.7, turn=turn)
        rotor = 6e-5 if name == "alone" else 8.9e-6
        momentum = rotor * (rates["omega"] + turn)
        if name != "alone":
            momentum += INERTIA[name] * (rates["omega_gear"] + turn)
        if name == "flexible load":
            momentum += 0.003 * rates["v_1"] + 0.001 * rates["v_2"]
        assert momentum == pytest.approx(0.7 - torque, rel=1e-9)


def test_without_anything_from_outside_nothing_changes():
    """Truth: the same mechanism without ports."""
    plain = to_flight(mechanism_of(changed(paper_table(), {"housing": None})))
    opened = with_ports(plain, list(Port))
    x = np.array([0.2, -0.3, 0.01, 0.5, 2e-4, 0.01, *[0.0] * 8]).tolist()
    modes, e = [1.0, 1.0], [0.4, 0.9]
    rates = [
        equations_of(m.plant).rates(
            x[: len(m.plant.states) + len(m.plant.filter.states)], inputs, modes, m.kernel_values().tolist()
        )
        for m, inputs in ((plain, e), (opened, [*e, 0.0, 0.0, 0.0]))
    ]
    np.testing.assert_allclose(rates[1], rates[0], rtol=1e-13)


@pytest.mark.parametrize(("name", "word"), [("paper", "voltage"), ("current drive", "current"), ("supply", "voltage")])
def test_what_is_added_in_a_phase_is_more_of_what_drives_it(name, word):
    """Truth: the coil's equation; a volt more is 1/L A/s more, an ampere more is an ampere."""
    mechanism = flying(name, Base.HELD)
    plant = mechanism.plant.with_outputs(["current_phase_a"])
    places = {s.name: k for k, s in enumerate(plant.inputs)}
    equations, p = equations_of(plant), mechanism.kernel_values()
    known = dict(zip(map(str, mechanism.plant.parameters), p, strict=True))
    p = [known[str(s)] for s in plant.parameters]
    x = [0.1] * len(plant.states)
    ends = []
    for added in (0.0, 1.0):
        inputs = [0.0] * len(plant.inputs)
        inputs[places["e_A"]], inputs[places[f"added_{word}_phase_a"]] = 0.5, added
        ends.append([equations.rates(x, inputs, [0.0, 0.0], p)[0], equations.outputs(x, inputs, [0.0, 0.0], p)[0]])
    more = np.subtract(*ends[::-1])
    assert more[1 if word == "current" else 0] == pytest.approx(1.0 if word == "current" else 1.0 / 0.045, rel=1e-12)
