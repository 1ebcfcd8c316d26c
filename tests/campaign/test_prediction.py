"""`mechid.simulate`; truth: the simulator called by hand, and the record's own time base."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism, load_campaign, mechanism_text
from mechid.campaign.prediction import simulate, simulate_all, time_base_warnings
from mechid.errors import InputFileError, RecordError, UsageError
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run


@pytest.fixture
def folder(folder):
    """Return the small campaign with the catalogue's mechanism, whose kernel other tests use too."""
    (folder / "mechanism.toml").write_text(mechanism_text(catalogue_mechanism()))
    return folder


@pytest.fixture
def campaign(folder):
    return load_campaign(folder)


def test_it_is_the_simulator_on_the_records_time_base(campaign):
    by_hand = Simulator(campaign.mechanism.plant, campaign.records[0].command, TimeBase(1000.0, 1001))
    expected = simulate_run(by_hand.run(campaign.mechanism.kernel_values(), substeps=4))
    found = simulate(campaign, "full_46", substeps=4)
    assert np.array_equal(found.time, expected.time)
    assert np.array_equal(found.torque, expected.torque)


def test_the_records_time_offset_shifts_the_run(changed):
    changed("campaign.toml", "time_offset_s = { value = 0.0,", "time_offset_s = { value = 0.001,")
    campaign = load_campaign(changed("campaign.toml", 'name = "sweep"', 'name = "late"'))
    late, early = simulate(campaign, "late", substeps=8), simulate(_at_zero(campaign), "late", substeps=8)
    assert late.torque[1:] == pytest.approx(early.torque[:-1], abs=1e-12)


def _at_zero(campaign):
    records = [replace(r, parameters=tuple(replace(q, value=0.0) for q in r.parameters)) for r in campaign.records]
    return replace(campaign, records=tuple(records))


def test_a_file_not_yet_read_is_read(folder, campaign):
    unread = load_campaign(folder, read_records=False)
    assert np.array_equal(simulate(unread, "full_46").torque, simulate(campaign, "full_46").torque)
    (folder / "full_46.csv").unlink()
    with pytest.raises(RecordError, match="there is no such file"):
        simulate(unread, "full_46")


def test_another_time_base_may_be_asked_for(campaign):
    assert simulate(campaign, "full_46", sample_rate_hz=2000.0).time.size == 2001
    assert simulate(campaign, "full_46", duration_s=0.25).time[-1] == 0.25
    both = simulate(campaign, "full_46", sample_rate_hz=500.0, duration_s=0.5)
    assert np.array_equal(both.time, np.arange(251) / 500.0)


def test_all_records_by_name(campaign):
    assert list(simulate_all(campaign)) == ["full_46", "sweep"]


def test_a_record_has_to_be_named_where_there_are_several(campaign):
    with pytest.raises(UsageError, match="full_46, sweep"):
        simulate(campaign)
    alone = replace(campaign, records=campaign.records[:1])
    assert simulate(alone).time.size == 1001
    with pytest.raises(UsageError, match='did you mean "full_46"'):
        simulate(campaign, "full_64")


@pytest.mark.parametrize(
    ("given", "rate_hz", "seconds"),
    [
        ({}, 1000.0, 1.0),  # as the sweep's file is sampled, and a second
        ({"sample_rate_hz": 500.0}, 500.0, 1.0),
        ({"duration_s": 0.3}, 1000.0, 0.3),
    ],
)
def test_a_record_without_a_file_is_planned(changed, given, rate_hz, seconds):
    path = changed("campaign.toml", 'file = "full_46.csv"\n', "")
    campaign = load_campaign(path, need_files=False)
    time = simulate(campaign, "full_46", **given).time
    assert time.tolist() == [k / rate_hz for k in range(round(rate_hz * seconds) + 1)]


def test_what_is_assumed_of_a_planned_record_is_said(changed):
    """Truth: the end of the sweep's rate profile, 1 s, and 10 kHz, since no file is read that says it otherwise."""
    changed("campaign.toml", 'file = "full_46.csv"\n', "")
    path = changed("campaign.toml", 'file = "sweep.csv"\n', "")
    changed("campaign.toml", "[1.0, 20.0]", "[3.5, 20.0]")
    campaign = load_campaign(path, need_files=False)
    assert [line.partition("; ")[0] for line in time_base_warnings(campaign, None, None)] == [
        'record "full_46" has no file: simulated for 1 s at 10000 Hz',
        'record "sweep" has no file: simulated for 3.5 s at 10000 Hz',
    ]


def test_rate_and_duration_that_are_given_are_for_records_without_a_file(changed):
    path = changed("campaign.toml", 'file = "full_46.csv"\n', "")
    campaign = load_campaign(path, need_files=False)
    assert simulate_all(campaign, sample_rate_hz=500.0, duration_s=0.5)["full_46"].time.size == 251
    assert simulate_all(campaign, sample_rate_hz=500.0, duration_s=0.5)["sweep"].time.size == 1001
    assert time_base_warnings(campaign, 500.0, 0.5) == ()


def test_the_records_own_sample_rate_counts_where_it_has_no_file(changed):
    path = changed("campaign.toml", 'file = "full_46.csv"', "sample_rate_hz = 800.0")
    campaign = load_campaign(path, need_files=False)
    assert simulate(campaign, "full_46", duration_s=1.0).time.size == 801


def test_too_many_steps_are_the_campaign_files_fault(changed):
    path = changed("campaign.toml", "rate = 46.0", "rate = 4.6e9")
    campaign = load_campaign(path, read_records=False)
    with pytest.raises(InputFileError, match=r'campaign\.toml: record "full_46": command'):
        simulate(campaign, "full_46")
    with pytest.raises(UsageError, match="substeps"):
        simulate(load_campaign(path.parent, read_records=False), "sweep", substeps=0)
