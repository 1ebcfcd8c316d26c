"""What may stand beside a mechanism: its words, what growth frees of it, and what cannot be sized."""

import numpy as np
import pytest

from layouts import SINGLE_STEPPER, mechanism_of
from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.plant.detent import period_name
from mechid.plant.superset import (
    extension_named,
    extensions_at,
    rivals_of,
    superset_of,
    unlisted_extensions,
    with_tables,
    words_of,
)
from paper import constant
from runs import base, run_kernel

GROWN = (
    "stepper.torque_harmonic:3",
    "stepper.torque_harmonic:5",
    "stepper.imbalance",
    "stepper.phase_offset",
    "stepper.detent:7.2deg",
    "stepper.detent:0.9deg",
    "stepper.detent:0.6deg",
    "stepper.detent:0.45deg",
    "friction.directional",
    "gear.kinematic_error:1",
    "gear.kinematic_error:2",
    "gear.kinematic_error:4",
)
"""What growth frees first beside the paper's mechanism: more, as prototypes measured, spoils it."""
RARER = (
    "stepper.torque_harmonic:7",
    "stepper.torque_harmonic:9",
    "stepper.torque_harmonic:2",
    "stepper.torque_harmonic:4",
    "stepper.detent:2.4deg",
    "stepper.detent:1.44deg",
    "stepper.detent:1.2deg",
    "stepper.detent:1.03deg",
    "gear.kinematic_error:3",
    "gear.kinematic_error:5",
    "gear.kinematic_error:6",
    "gear.kinematic_error:7",
    "gear.kinematic_error:8",
)
"""What it frees where these do not suffice."""


def following_voltages():
    """Return the catalogue's mechanism on measured voltages: no file says how large they are."""
    stepper = {k: v for k, v in CATALOGUE["stepper"].items() if k != "peak_voltage"} | {"drive": "measured_voltage"}
    return mechanism_from_table({**CATALOGUE, "stepper": stepper}, "on measured voltages")


def test_growth_frees_the_terms_it_was_measured_with():
    """Truth: the library with which growth was measured."""
    superset = superset_of(catalogue_mechanism(), grown_only=True)
    assert tuple(term.name for term in superset.terms if not term.rarer) == GROWN
    assert tuple(term.name for term in superset.terms if term.rarer) == RARER
    every = {term.name for term in superset_of(catalogue_mechanism()).terms}
    assert every > {*GROWN, *RARER}


def test_terms_of_one_name_are_one():
    """Truth: both harmonics of a microstep table, which are there together or not."""
    (table,) = (t for t in superset_of(catalogue_mechanism()).terms if t.name == "stepper.microstep_table")
    assert {name.removeprefix("stepper.microstep_table.") for name in table.widths} == {"0.amplitude", "1.amplitude"}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("stepper.detent:0.9deg", "detent torque with a period of 0.9 deg of the rotor"),
        ("stepper.torque_harmonic:3", "3rd harmonic of the torque constant"),
        ("stepper.imbalance", "the two phases differ in torque constant, resistance or inductance"),
        ("stepper.saliency", "the coils' inductance varies with the rotor's angle"),
        ("supply.sag", "the supply voltage falls with the current drawn"),
        ("friction.position:2", "dry friction varies with the angle of the rotor, 2 per turn"),
        ("friction.position:output:1", "dry friction varies with the angle of the output, 1 per turn"),
        ("housing.second_mode", "second resonance of the housing"),
        ("stepper.microstep_table", "error of the driver's microstep table"),
        ("gear.kinematic_error:2", "kinematic error of the gear, 2 per turn of its input"),
        ("friction.stribeck", "friction falls with speed (Stribeck)"),
    ],
)
def test_words_carry_the_numbers(name, words):
    assert words_of(catalogue_mechanism())[name] == words


def test_all_that_may_stand_beside_has_words():
    mechanism = catalogue_mechanism()
    words = words_of(mechanism)
    terms = superset_of(mechanism).terms
    assert {term.name: term.words for term in terms}.items() <= words.items()
    assert {law.name for law in rivals_of(mechanism)} <= words.keys()
    assert all(words.values())
    assert not any("{" in each for each in words.values())


@pytest.mark.slow
def test_a_rival_with_an_amplitude_is_none_of_it_where_that_is_0():
    """Truth: the mechanism itself."""
    plain = catalogue_mechanism()
    time_base, command = base(0.05), constant(46.0)
    torque = run_kernel(plain, command, time_base).torque
    (law,) = (law for law in rivals_of(plain) if law.name == "housing.second_mode")
    assert law.null == "housing.second_mode.gain"
    assert len(law.tries) == 21
    for values in (law.tries[0], law.tries[-1]):
        other = law.at_null(values)
        assert [p.name for p in other.free if p.name not in plain.parameters] == [law.null]
        assert {name: other.value(name) for name in values} == values
        np.testing.assert_allclose(
            run_kernel(other, command, time_base).torque, torque, rtol=0, atol=1e-9 * np.abs(torque).max()
        )


def test_growth_tries_the_laws_it_was_measured_with():
    names = [law.name for law in rivals_of(catalogue_mechanism(), grown_only=True)]
    assert names == [
        "stepper.detent_hysteresis",
        "friction.stribeck",
        "gear.backlash",
        "gear.backlash",
        "friction.load_dependent",
        "output_friction",
        "charge_amplifier",
        "anti_alias:4",
    ]


def test_a_current_drive_may_run_out_of_voltage():
    mechanism = mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    assert words_of(mechanism)["stepper.current_limit"] == "the current drive runs out of voltage"
    (limited,) = (law.mechanism for law in rivals_of(mechanism) if law.name == "stepper.current_limit")
    assert {"stepper.current_limit.voltage", "stepper.current_limit.inductance"} <= {p.name for p in limited.free}
    assert limited.value("stepper.current_limit.back_emf_constant") == mechanism.value("stepper.torque_constant")
    assert "stepper.current_limit" not in {law.name for law in rivals_of(mechanism, grown_only=True)}


def test_what_no_value_sizes_is_left_out():
    names = {term.name for term in superset_of(following_voltages()).terms}
    assert "stepper.imbalance" in names
    assert "stepper.phase_offset" not in names, "an offset of a measured voltage: no supply to take a share of"


def test_a_bent_gear_has_no_rival_that_its_stiffness_would_size():
    gear = {
        "law": "piecewise_linear",
        "ratio": 50,
        "stiffness_1": 900.0,
        "stiffness_2": 1500.0,
        "stiffness_3": 2000.0,
        "torque_1": 1.0,
        "torque_2": 3.0,
        "damping": 0.4,
    }
    bent = mechanism_from_table({**CATALOGUE, "gear": gear}, "bent")
    assert "output_friction" not in {law.name for law in rivals_of(bent)}


def test_a_period_that_no_list_has_is_laid_out_from_what_a_record_shows():
    """Truth: 200 full steps are a turn of the paper's rotor; 137 periods in it are 2.628 deg of a detent."""
    mechanism = catalogue_mechanism()
    found = extensions_at(mechanism, 137.2 / 200.0, near=1)
    periods = [360.0 / float(e.structure["period_deg"]) for e in found if e.table == "stepper.detent"]
    assert periods == pytest.approx([137.0, 136.0, 138.0])
    assert [e.order for e in found if e.table == "gear.kinematic_error"] == [137, 136, 138]
    wide = superset_of(mechanism, further=found)
    assert {"stepper.detent:2.63deg", "gear.kinematic_error:137"} <= {t.name for t in wide.terms}
    again = extension_named(mechanism, "stepper.detent:2.63deg")
    assert float(again.structure["period_deg"]) == pytest.approx(360.0 / 137.0)
    assert extension_named(mechanism, "stepper.detents:2.63deg") is None


def test_a_period_that_is_there_or_listed_asks_for_nothing_further():
    """Truth: the paper's detent of 3.6 deg has half a period in a full step, the listed one of 0.9 deg two."""
    assert extensions_at(catalogue_mechanism(), 0.5, near=1) == []
    assert extensions_at(catalogue_mechanism(), 2.0, near=1) == []


def test_names_tell_any_two_numbers_of_periods_apart():
    """Truth: the number of periods that a name stands for, read back from it."""
    names = [period_name(360.0 / periods) for periods in range(1, 401)]
    assert [round(360.0 / float(name.removesuffix("deg"))) for name in names] == list(range(1, 401))
    assert names[299] == "1.2deg", "three digits where they suffice"


def test_unlisted_terms_are_those_that_no_list_and_no_file_has_and_lay_out_alike():
    """Truth: the catalogue's detents of 100 and 200 periods; the lists of the blocks; plants of one digest."""
    mechanism = catalogue_mechanism()
    found = unlisted_extensions(mechanism)
    detents = [e for e in found.values() if e.table == "stepper.detent"]
    periods = {round(360.0 / float(e.structure["period_deg"])) for e in detents}
    listed = {50 * order for order in (1, 2, 3, 4, 5, 6, 7, 8)}
    assert periods == set(range(1, 401)) - listed
    over_angles = [name for name, e in found.items() if e not in detents]
    assert over_angles == [
        *(f"friction.position:{order}" for order in range(1, 9)),
        *(f"friction.position:output:{order}" for order in range(1, 101)),
    ], "no kinematic errors: two orders are two plants"
    for names in (("stepper.detent:2.77deg", "stepper.detent:0.914deg"), (over_angles[0], over_angles[5])):
        one, other = (superset_of(mechanism, only=[name], further=[found[name]]) for name in names)
        assert [term.name for term in one.terms] == [names[0]]
        assert one.mechanism.plant.digest == other.mechanism.plant.digest


def test_a_term_is_free_no_further_than_a_file_may_have_it():
    """Truth: ten widths of 0.2 are more than all of dry friction, which is the most that varies."""
    superset = superset_of(catalogue_mechanism(), only=["friction.position:1"])
    assert superset.with_free_terms(["friction.position:1"]).parameters["friction.position.0.amplitude"].max == 1.0


def test_friction_over_the_angle_that_a_file_has_is_not_asked_for_again():
    """Truth: the file."""
    position = [{"order": 2, "amplitude": 0.1}, {"order": 7, "amplitude": 0.1}]
    friction = {**CATALOGUE["friction"], "position": position}
    mechanism = mechanism_from_table({**CATALOGUE, "friction": friction}, "with friction over the angle")
    over_rotor = {f"friction.position:{order}" for order in range(1, 9)}
    assert over_rotor - unlisted_extensions(mechanism).keys() == {"friction.position:2", "friction.position:7"}
    assert over_rotor & words_of(mechanism).keys() == {"friction.position:1"}


def test_a_table_is_laid_out_with_its_defaults():
    """Truth: the mechanism itself: a gain of 1 changes nothing."""
    plain = catalogue_mechanism()
    wide = with_tables(plain, ("transducer",))
    assert wide.value("transducer.gain") == 1.0
    assert wide.parameters.keys() - plain.parameters.keys() == {"transducer.gain"}
    assert with_tables(wide, ("transducer",)) is wide
    superset = superset_of(plain, only=["stepper.imbalance"], tables=("transducer",))
    assert "transducer.gain" in superset.mechanism.parameters
    assert "transducer.gain" not in superset.term_of
