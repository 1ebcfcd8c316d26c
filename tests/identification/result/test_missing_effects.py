"""What the files lack, as a fit writes it down. Truth: entries made by hand."""

from dataclasses import replace

import pytest

from mechid.identification.result.missing_effects import EffectValue, Missing, missing_warning

VOLTAGES = {
    "full_46.voltage": EffectValue(value=24.0, std_error=0.01, unit="V"),
    "full_23.voltage": EffectValue(value=26.0, std_error=None, unit="V"),
}
VOLTAGE = Missing(
    name="record.voltage",
    words="a supply voltage of its own in each record",
    parameters=VOLTAGES,
    chi_square=120.0,
    dof=1,
    share=0.75,
    p_value=1e-20,
    records=("full_46", "full_23"),
    toml="[records.full_46]\n",
    aliases=("record.current",),
)


def test_an_entry_comes_back_from_what_is_written():
    own = VOLTAGE.to_dict()
    assert own["records"] == ["full_46", "full_23"]
    assert own["parameters"]["full_46.voltage"] == {"value": 24.0, "std_error": 0.01, "unit": "V"}
    assert Missing.from_dict(own) == VOLTAGE


def test_a_warning_names_values_with_their_errors_and_how_to_keep_the_effect_out():
    said = missing_warning(VOLTAGE)
    assert "full_46.voltage = 24 +- 0.01 V, full_23.voltage = 26 V" in said
    assert "chi-square 120 for 1, 75 % of the misfit beyond noise" in said
    assert 'disturbances = "none" in [identify] to exclude it' in said


def test_values_that_have_a_mean_say_how_far_it_may_be_off():
    """Truth: 24 and 26 V scatter by sqrt(2) V about 25 V, 5.66 %, and their mean by 4 % over the root of two."""
    assert "they scatter by 5.7 %, so it may have an undetected error of 4 %" in missing_warning(VOLTAGE)
    assert "scatter" not in missing_warning(replace(VOLTAGE, dof=2))


@pytest.mark.parametrize(("values", "dots"), [(8, False), (9, True)])
def test_a_warning_names_eight_values_at_most(values, dots):
    many = {f"r{n}.voltage": EffectValue(value=float(n), std_error=None, unit="V") for n in range(values)}
    said = missing_warning(replace(VOLTAGE, parameters=many, dof=values))
    assert ("..." in said) is dots
    assert ("r8.voltage" in said) is False
