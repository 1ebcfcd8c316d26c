"""Detent torque over temperature. Truth: records of the independent simulator, its detents 40 K warmer by hand."""

import json

import numpy as np
import pytest

import mechid
from incomplete.benches import drawn
from incomplete.recording import Run, recorded

COMMAND = {"stepping": "full", "rate": 23.0, "start_angle_deg": 45.0}
COEFFICIENT, RISE_K = -2e-3, 40.0
DETENTS = ("stepper.detent.0.amplitude", "stepper.detent.1.amplitude")


@pytest.fixture
def campaign(tmp_path):
    """Return a campaign of a cold and a warm record of one mechanism; its detents and their coefficient are unknown."""
    true, _ = drawn("nothing", 3)
    warm = true.with_values({name: true.value(name) * (1.0 + COEFFICIENT * RISE_K) for name in DETENTS})
    text = mechid.campaign.mechanism_text(true.with_free(DETENTS))
    free = "{ value = 0.0, min = -0.01, max = 0.01 }"
    (tmp_path / "mechanism.toml").write_text(f"{text}\n[stepper.magnet]\ndetent_per_K = {free}\n", encoding="utf-8")
    records = []
    for name, mechanism, rise in (("cold", true, 0.0), ("warm", warm, RISE_K)):
        found = recorded(mechanism, {}, Run(COMMAND, 0.4), np.random.default_rng(7))
        np.savetxt(
            tmp_path / f"{name}.csv",
            np.column_stack([found.time_s, found.torque_Nm]),
            delimiter=",",
            header="time_s,torque_Nm",
            comments="",
        )
        command = ", ".join(f"{key} = {json.dumps(value)}" for key, value in COMMAND.items())
        records.append(
            f'[[record]]\nname = "{name}"\nfile = "{name}.csv"\ncommand = {{ {command} }}\ntemperature_rise = {rise}\n'
        )
    file = tmp_path / "campaign.toml"
    file.write_text('mechanism = "mechanism.toml"\nsynthetic = true\n' + "".join(records), encoding="utf-8")
    return file


@pytest.mark.slow
def test_two_temperatures_tell_the_coefficient(campaign):
    fit = mechid.identify(mechid.load_campaign(campaign), workers=1)
    found = fit.parameters["stepper.magnet.detent_per_K"]
    assert fit.grade == "A"
    assert abs(found.value - COEFFICIENT) < 3.0 * found.std_error
    assert found.std_error < 0.05 * abs(COEFFICIENT)


@pytest.mark.slow
def test_records_at_one_temperature_do_not_see_it(campaign):
    """Truth: a rise of zero in each record leaves the coefficient without effect; no value is made up for it."""
    text = campaign.read_text(encoding="utf-8").replace(f"temperature_rise = {RISE_K}", "temperature_rise = 0.0")
    campaign.write_text(text, encoding="utf-8")
    loaded = mechid.load_campaign(campaign)
    checked = mechid.check(loaded)
    assert any("stepper.magnet.detent_per_K: no record sees it" in line for line in map(str, checked.warnings))
