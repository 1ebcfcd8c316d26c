"""Truth: parameters that by the equations change nothing, and those that do."""

import pytest

from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.bench import write_bench
from mechid.identification.identifiability.visibility import sensitivities, start_warnings, unseen_parameters

FREE_OFFSET = "time_offset_s = { value = 0.0, min = -0.002, max = 0.002 }"


@pytest.fixture
def folder(tmp_path):
    write_bench(tmp_path, seed=1, sweep_s=0.1)
    return tmp_path


def change(path, old, new):
    content = path.read_text()
    assert old in content
    path.write_text(content.replace(old, new, 1))


def test_the_bench_sees_all_its_parameters(folder):
    """Also the phase of the detent that starts at zero amplitude, searched as cosine and sine."""
    campaign = load_campaign(folder)
    assert unseen_parameters(campaign) == ()
    assert start_warnings(campaign) == ()


def test_the_phase_of_a_detent_known_to_be_zero_is_unseen(folder):
    change(folder / "mechanism.toml", "amplitude = { value = 0.0, min = 0.0, max = 0.1 }", "amplitude = 0.0")
    assert unseen_parameters(load_campaign(folder)) == ("stepper.detent.1.phase_deg",)


def test_a_mechanism_at_rest_shows_nothing_of_itself(folder):
    """Without a step and without detents the rotor stays where it is and no torque is measured."""
    path = folder / "campaign.toml"
    head, _, _ = path.read_text().partition('\n[[record]]\nname = "full_46"')
    path.write_text(head.replace("rate = 23.0", "rate = 0.0") + FREE_OFFSET + "\n")
    mechanism = folder / "mechanism.toml"
    for old in (
        "amplitude = { value = 0.01, min = 0.0, max = 0.1 }",
        "amplitude = { value = 0.0, min = 0.0, max = 0.1 }",
    ):
        change(mechanism, old, "amplitude = 0.0")
    campaign = load_campaign(folder)
    assert set(unseen_parameters(campaign)) == {q.name for q in campaign.free}
    assert "record.full_23.time_offset_s" in unseen_parameters(campaign)


def test_a_record_for_validation_sees_nothing(folder):
    """The time offset of a record that is not fitted is nobody's to estimate, and is not asked about."""
    path = folder / "campaign.toml"
    path.write_text(path.read_text() + 'use = "validate"\n' + FREE_OFFSET + "\n")
    assert unseen_parameters(load_campaign(folder)) == ()


def test_a_mechanism_that_diverges_is_told_for_each_record(folder):
    change(folder / "mechanism.toml", "inertia = 0.010534", "inertia = 1e-9")
    warnings = [line for line in start_warnings(load_campaign(folder)) if line.startswith("record")]
    assert all("at the values of the mechanism file" in line for line in warnings)
    assert {f'record "full_{rate}"' for rate in (23, 46, 92)} <= {line.partition(" at")[0] for line in warnings}


def test_nothing_free_has_nothing_to_see(folder):
    campaign = load_campaign(folder)
    text = mechanism_text(campaign.mechanism.with_free(()))
    (folder / "mechanism.toml").write_text(text)
    known = load_campaign(folder)
    assert sensitivities(known) == 0
    assert start_warnings(known) == ()
