"""What of a mechanism file shapes the equations. Truth: the mechanism read back; the nearest right word."""

import pytest

from layouts import BRUSHED_DC, LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table, paper_with
from mechid.campaign import load_mechanism, mechanism_text
from mechid.errors import InputFileError
from mechid.plant.mechanisms import ASSEMBLIES
from mechid.plant.tables import CHOICES

FRICTION = {"static": 0.01, "coulomb": 0.005, "viscous": 1e-3}
TABLES = {
    "stepper_gear_mass": paper_table(),
    "current_driven_stepper": SINGLE_STEPPER,
    "direct_torque_drive": {"load": {"inertia": 1e-3}, "friction": FRICTION, "drive": {"offset": 0.1}},
    "direct_force_drive": {"load": {"mass": 95.0}, "friction": FRICTION, "drive": {"offset": -3.0}},
    "two_mass_drive": {
        "motor": {"inertia": 1e-4},
        "friction": FRICTION,
        "gear": {"ratio": 1, "stiffness": 50.0, "damping": 0.1},
        "load": {"inertia": 1e-3},
        "output_friction": {"coulomb": 0.01},
        "drive": {},
    },
    "brushed_dc_drive": {**BRUSHED_DC, "spring": {"stiffness": 0.05, "rest_angle": 0.2}},
}


PAIRS = [("stepper_gear_mass", name) for name in LAYOUTS]
PAIRS += [("two_mass_drive", name) for name in ("unbalance", "cable")]
PAIRS += [(assembly, "stribeck") for assembly in ASSEMBLIES if assembly != "stepper_gear_mass"]
"""Every layout of the paper's assembly; of the others one law is enough."""


@pytest.mark.parametrize(("assembly", "layout"), PAIRS)
def test_a_mechanism_written_is_read_back(assembly, layout, tmp_path):
    """Truth: the mechanism itself."""
    changes = LAYOUTS[layout]
    m = mechanism_of(changed({"assembly": assembly, **TABLES[assembly]}, changes))
    (tmp_path / "mechanism.toml").write_text(mechanism_text(m))
    again = load_mechanism(tmp_path / "mechanism.toml")
    assert again.plant == m.plant
    assert again.options == m.options
    assert {n: (q.value, q.status) for n, q in again.parameters.items()} == {
        n: (q.value, q.status) for n, q in m.parameters.items()
    }


def test_a_law_that_is_the_default_is_the_paper_s_plant():
    spelt = {"stepper": {"drive": "voltage"}, "friction": {"law": "coulomb"}, "gear": {"law": "linear"}}
    assert paper_with(spelt).plant == paper_with({}).plant


@pytest.mark.parametrize("table", [name for name in CHOICES if name != "housing"])
def test_a_law_that_is_none_is_answered_with_the_nearest(table):
    wrong = list(CHOICES[table])[-1][:-1] + "x"
    key = {"stepper": "drive", "stepper.pulses": "between", "stepper.chop": "decay"}.get(table, "law")
    entry = {key: wrong}
    for name in reversed(table.split(".")):
        entry = {name: entry}
    with pytest.raises(InputFileError) as caught:
        paper_with(entry)
    start = f'mechanism.toml: {table}.{key}: unknown {key} "{wrong}"; did you mean "{list(CHOICES[table])[-1]}"?'
    assert str(caught.value) == start


REFUSED = {
    "key of another law": (
        {"friction": {"stribeck_rate": 2.0}},
        'friction.stribeck_rate: unknown key; it belongs to law = "stribeck"',
    ),
    "key of another drive": (
        {"stepper": {"peak_current": 0.6}},
        'stepper.peak_current: unknown key; it belongs to drive = "current"',
    ),
    "key of the law missing": (
        {"gear": {"law": "backlash"}},
        "gear.backlash: missing; write backlash under [gear], free travel of the output from flank to flank in rad",
    ),
    "key of the default law": (
        {"gear": {"law": "piecewise_linear"}},
        'gear.stiffness: unknown key; it belongs to law = "linear"',
    ),
    "bends exchanged": (
        {"gear": LAYOUTS["piecewise_linear"]["gear"] | {"torque_2": 0.05}},
        "gear.torque_2: 0.05 is not above gear.torque_1 = 0.08; exchange them",
    ),
    "modes heavier than the load": (
        {"load": {"mode": [{"frequency": 190.0, "damping": 0.01, "inertia": 0.02}]}},
        "load.inertia: 0.010534 is not above the modes' 0.02",
    ),
    "order that is not whole": (
        {"stepper": {"torque_harmonic": [{"order": 2.5, "amplitude": 1e-4}]}},
        "stepper.torque_harmonic.0.order: found 2.5; write a whole number",
    ),
    "order beyond the kernel's": (
        {"gear": {"kinematic_error": [{"order": 1001, "amplitude": 1e-4}]}},
        "gear.kinematic_error.0.order: found 1001; write a whole number up to 1000",
    ),
    "order that no filter has": (
        {"anti_alias": {"order": 900, "frequency": 3000.0}},
        "anti_alias.order: found 900",
    ),
    "order missing": (
        {"stepper": {"torque_harmonic": [{"amplitude": 0.1}]}},
        "stepper.torque_harmonic.0.order: missing; write order under [[stepper.torque_harmonic]]",
    ),
    "list that is a table": (
        {"load": {"mode": {"frequency": 190.0}}},
        "load.mode: found a table; write each mode as a table under [[load.mode]], in two brackets",
    ),
    "second mode without the first": (
        {"housing": {"gain": None, "frequency": None, "damping": None, "second_mode": {"gain": 0.1}}},
        "housing.gain: missing; write gain under [housing], housing resonance factor",
    ),
    "friction per turn of what slides": (
        {"assembly": "direct_force_drive", "friction": {"position": [{"order": 1, "amplitude": 0.1}]}},
        "friction.position: is per turn, and this axis slides; delete it",
    ),
    "friction over an output that is not there": (
        {"assembly": "current_driven_stepper", "friction": {"output_position": [{"order": 1, "amplitude": 0.1}]}},
        "friction.output_position: there is no gear, the output is the rotor; write [[friction.position]]",
    ),
    "current limit of a voltage drive": (
        {"stepper": {"current_limit": {"voltage": 24.0, "resistance": 9.9, "inductance": 0.045}}},
        'stepper.current_limit: belongs to drive = "current", found "voltage"; delete the table',
    ),
    "inductance of a current drive": (
        {"stepper": {**LAYOUTS["current drive"]["stepper"], "saliency": {"share": 0.1}}},
        'stepper.saliency: drive = "current" knows no inductance; delete the table',
    ),
    "source of a current drive": (
        {**LAYOUTS["current drive"], "supply": {"resistance": 1.0}},
        'supply: drive = "current" does not see what its source does; delete the table',
    ),
    "key of another cable": (
        {"load": {"cable": {"stiffness": 0.1, "hysteresis": 0.01}}},
        'load.cable.hysteresis: unknown key; it belongs to law = "dahl"',
    ),
    "table that is a number": (
        {"load": {"unbalance": {"value": 0.1, "min": 0.0, "max": 1.0}}},
        "load.unbalance: unknown key; its own are in a table, [load.unbalance]",
    ),
    "misspelt table": (
        {"output_frction": {"coulomb": 0.1}},
        'output_frction: unknown table; did you mean "output_friction"?',
    ),
    "law that is no text": ({"friction": {"law": 3}}, 'friction.law: found 3; write law = "coulomb", or leave it out'),
    "misspelt table in a table": (
        {"load": {"cabel": {"stiffness": 0.1}}},
        'load.cabel: unknown key; did you mean "cable"?',
    ),
    "law that the assembly has not": (
        {"assembly": "current_driven_stepper", "gear": None, "load": None, "friction": {"law": "load_dependent"}},
        'friction.law: unknown law "load_dependent"',
    ),
    "table that the assembly has not": ({"assembly": "direct_torque_drive"}, "stepper: unknown table"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_fit_together_is_said_with_its_place(case, refused):
    changes, message = REFUSED[case]
    refused(f"mechanism.toml: {message}", paper_with, changes)


HARMONICS = {
    "gear.kinematic_error": "92*",
    "stepper.torque_harmonic": "46*alpha*p",  # p counts both poles of a pair
}


@pytest.mark.parametrize("table", HARMONICS)
def test_a_harmonic_of_high_order_is_not_one_of_order_64(table):
    """Truth: sines of 92 times an angle in the equations; 64 was the highest order once, and higher ones became it."""
    head, key = table.split(".")
    plant = paper_with({head: {key: [{"order": 92, "amplitude": 1e-3}]}}).plant
    assert plant.layout.orders[table] == (92,)
    written = " ".join(str(e) for _, e in plant.terms) + " ".join(map(str, plant.rates))
    assert f"sin({HARMONICS[table]}" in written


@pytest.mark.parametrize("key", ["position", "output_position"])
def test_the_order_of_friction_over_the_angle_is_a_value(key):
    """Truth: one plant of two orders, each of which the mechanism has."""
    one, other = (paper_with({"friction": {key: [{"order": k, "amplitude": 0.1}]}}) for k in (92, 3))
    assert one.plant.digest == other.plant.digest
    assert one.value(f"friction.{key}.0.order") == 92.0
    assert one.plant.layout.orders[f"friction.{key}"] == (None,)


def test_an_order_of_friction_over_the_angle_is_whole(refused):
    changes = {"friction": {"position": [{"order": 1.5, "amplitude": 0.1}]}}
    refused("mechanism.toml: friction.position.0.order: found 1.5; write a whole number", paper_with, changes)
