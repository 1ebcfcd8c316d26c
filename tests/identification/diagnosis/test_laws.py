"""Laws in place of those of a mechanism. Truth: the law that the records were made with."""

from dataclasses import replace

import numpy as np

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.identify import identify
from synthetic import COMMANDS, TRUTH, campaign, measured, record


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
    before, _ = initial_models(fitted[1])
    friction = next(law for law in before.other_laws if law.name == "output_friction")
    one = before.in_place_of(friction, friction.mechanism.with_values({"output_friction.coulomb": 0.0123}))
    backlash = next(law for law in one.other_laws if law.name == "gear.backlash")
    both = one.in_place_of(backlash, backlash.mechanism)
    assert both.laws == ("output_friction", "gear.backlash")
    assert set(both.law_parameters) == {*friction.own, *backlash.own}
    assert both.base.value("output_friction.coulomb") == 0.0123
    assert "output_friction" not in {law.name for law in both.other_laws}
    assert set(before.base.parameters) < set(one.base.parameters) < set(both.base.parameters)
