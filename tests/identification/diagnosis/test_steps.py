"""Steps of a diagnosis: effects with periods seen, and exchanged. Truth: the effect that made the records."""

from dataclasses import replace

import numpy as np
import pytest

import mechid
from diagnosis_bench import tables
from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.command import RateProfile
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.steps import exchange_effect
from mechid.identification.identify import identify
from synthetic import COMMANDS, TRUTH, campaign, measured, record


@pytest.mark.slow
def test_a_detent_that_no_list_has_is_named_with_its_period():
    """Truth: the detent of 137 periods in a turn, 4 mN m and 30 deg, that made the records; a sweep of 8 s shows it."""
    third = {"period_deg": 360.0 / 137.0, "amplitude": 0.004, "phase_deg": 30.0}
    stepper = {**CATALOGUE["stepper"], "detent": [*CATALOGUE["stepper"]["detent"], third]}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "with a third detent").with_values(TRUTH)
    rising = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 0.0), (8.0, 110.0)]))
    commands = {"full_46": (COMMANDS["full_46"], 1.0), "micro_46": (COMMANDS["micro_46"], 1.0), "sweep": (rising, 8.0)}
    records = [
        record(n, measured(made_by, command, np.random.default_rng((5, k)), seconds=seconds), command)
        for k, (n, (command, seconds)) in enumerate(commands.items())
    ]
    bench = campaign(catalogue_mechanism(), *records)
    found = diagnose(identify(bench, workers=1, near=TRUTH), workers=1)
    (one,) = found.missing
    assert one.name == "stepper.detent:2.63deg"
    own = {name.rpartition(".")[2]: p for name, p in one.parameters.items()}
    assert abs(own["amplitude"].value - 0.004) < 4.0 * own["amplitude"].std_error < 1e-4
    assert abs(own["phase_deg"].value - 30.0) < 4.0 * own["phase_deg"].std_error < 2.0


@pytest.mark.slow
def test_an_alias_is_found_from_where_the_other_effect_is():
    """Truth: offsets of the phase voltages and a detent of 7.2 deg are one, so that either leaves the same."""
    imbalance = {"offset_a": 0.06, "offset_b": -0.04}
    made_by = mechanism_from_table({**tables(), "stepper": {**CATALOGUE["stepper"], "imbalance": imbalance}}, "apart")
    made_by = made_by.with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((3, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "micro_46"))
    ]
    bench = campaign(catalogue_mechanism(), *records)
    before, _ = initial_models(mechid.identify(bench, workers=1, near=TRUTH))
    detent = before.fit(before).with_effect("stepper.detent:7.2deg")
    offset = exchange_effect(detent, "stepper.detent:7.2deg", "stepper.phase_offset")
    assert offset.terms == ("stepper.phase_offset",)
    assert offset.cost == pytest.approx(detent.cost, abs=3.0)
    values = offset.problem.coordinates.values(offset.q)
    found = {name.rpartition(".")[2]: value for name, value in values.items() if "offset_" in name}
    assert found == pytest.approx(imbalance, rel=0.05)


def test_a_high_pass_that_hides_in_the_noise_is_found():
    """Truth: the time constant of the charge amplifier that the records went through."""
    table = {**CATALOGUE, "charge_amplifier": {"time_constant": 1.0}}
    made_by = mechanism_from_table(table, "with a charge amplifier").with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]
    bench = replace(campaign(catalogue_mechanism(), *records), considered=("charge_amplifier", "clock"))
    found = diagnose(identify(bench, workers=1, near=TRUTH), workers=1)
    assert [one.name for one in found.missing] == ["charge_amplifier"]
    own = found.missing[0].parameters["charge_amplifier.time_constant"]
    assert abs(own.value - 1.0) < 4.0 * own.std_error < 0.5


def test_a_law_stands_beside_another(fitted):
    """Truth: the parameters that each law has of its own, and the values with which the first one stood there."""
    campaign, fit = fitted
    before, _ = initial_models(
        replace(fit, campaign=replace(campaign, considered=("output_friction", "gear.backlash")))
    )
    friction = next(law for law in before.other_laws if law.name == "output_friction")
    one = before.use_law(friction, friction.mechanism.with_values({"output_friction.coulomb": 0.0123}))
    backlash = next(law for law in one.other_laws if law.name == "gear.backlash")
    both = one.use_law(backlash, backlash.mechanism)
    assert both.laws == ("output_friction", "gear.backlash")
    assert set(both.law_parameters) == {*friction.own, *backlash.own}
    assert both.base.value("output_friction.coulomb") == 0.0123
    assert "output_friction" not in {law.name for law in both.other_laws}
    assert set(before.base.parameters) < set(one.base.parameters) < set(both.base.parameters)
