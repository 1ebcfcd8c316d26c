"""The campaign file. Truth: the campaign contract, and a line with place and remedy for each way it can be wrong."""

import re

import pytest

from mechid.campaign import Match, load_campaign
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, RecordError
from mechid.parameter import Status


@pytest.mark.parametrize(("name", "free"), [("exact", 0), ("noisy", 15)])
def test_the_independent_campaigns_load_without_a_warning(name, free, campaign_folder):
    campaign = load_campaign(campaign_folder / name)
    names = ["full_res", "full_half", "full_slow", "micro_res", "micro_2res", "sweep"]
    assert [record.name for record in campaign.estimated] == names
    assert [record.data.samples for record in campaign.records] == [10001, 10001, 15001, 10001, 10001, 200001]
    assert len(campaign.free) == free
    assert (campaign.stages, campaign.warnings) == ((), ())


def test_a_campaign(folder):
    campaign = load_campaign(folder / "campaign.toml")
    first, second = campaign.records
    assert (campaign.path, campaign.mechanism_path) == (folder / "campaign.toml", folder / "mechanism.toml")
    assert (first.use, first.file) == ("estimate", folder / "full_46.csv")
    assert first.matches == (Match(quantity="torque", use="estimate", offset=True, drift=True),)
    rate = RateProfile.constant(46.0)
    assert first.command == Command(stepping="full", microsteps=1, rate=rate, start_angle_deg=45.0)
    assert (first.time_offset.value, first.time_offset.status) == (0.0, Status.KNOWN)
    assert (second.use, second.time_offset.name) == ("validate", "record.sweep.time_offset_s")
    assert (second.time_offset.min, second.time_offset.max) == (-0.002, 0.002)
    assert campaign.estimated == (first,)
    assert campaign.validated == (second,)
    assert campaign.record("sweep") is second
    assert campaign.warnings == ()


def test_records_may_be_left_unread(changed, folder):
    """Truth: simulation and planning need no measured files."""
    path = changed("campaign.toml", 'file = "full_46.csv"\n', "")
    (folder / "sweep.csv").unlink()
    campaign = load_campaign(path, read_records=False)
    assert [record.file for record in campaign.records] == [None, folder / "sweep.csv"]
    assert [record.data for record in campaign.records] == [None, None]


def test_a_file_that_is_missing_is_the_records_fault(folder):
    (folder / "sweep.csv").unlink()
    with pytest.raises(RecordError, match=r"^sweep\.csv: there is no such file") as caught:
        load_campaign(folder)
    assert caught.value.exit_code == 4


def test_a_folder_without_a_campaign(tmp_path):
    message = f'{tmp_path}: no campaign.toml in this folder; "mechid new {tmp_path}" writes one'
    with pytest.raises(InputFileError, match=f"^{re.escape(message)}$"):
        load_campaign(tmp_path)


def test_the_mechanisms_faults_are_the_campaigns(changed, folder):
    changed("mechanism.toml", "stiffness =", "stifness =")
    with pytest.raises(InputFileError, match=r"^mechanism\.toml: gear\.stifness: unknown key"):
        load_campaign(folder)


NAME = 'name = "full_46"'

REFUSED = {  # what is replaced, by what -> the message behind "campaign.toml: "
    "unknown table": ("[[record]]", "[[records]]", 'records: unknown key; did you mean "record"?'),
    "backslash": (
        '"full_46.csv"',
        '"data\\xfull_46.csv"',
        "line 5, column ",
    ),
    "no mechanism": (
        'mechanism = "mechanism.toml"',
        "",
        'mechanism: missing; write the name of the mechanism file, as mechanism = "mechanism.toml"',
    ),
    "mechanism of a wrong type": (
        'mechanism = "mechanism.toml"',
        "mechanism = 1",
        'mechanism: found 1; write the name of the mechanism file, as mechanism = "mechanism.toml"',
    ),
    "mechanism below a record": (
        NAME,
        f'{NAME}\nmechanism = "mechanism.toml"',
        "record[0].mechanism: mechanism is no key of a record; write it above the first [[record]]",
    ),
    "option": (
        "[[record]]",
        "[identify]\nworkers = 2\n[[record]]",
        "identify.workers: unknown key; "
        "the keys here are priors, colour, spikes, freeze, max_relative_error, max_correlation",
    ),
    "options of a wrong type": (
        "[[record]]",
        "identify = 1\n[[record]]",
        "identify: found 1; write a table, [identify]",
    ),
    "no toml": ("[[record]]", "[[record]", "line 3, column "),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_file_says_where_what_and_the_remedy(name, changed, refused):
    old, new, message = REFUSED[name]
    path = changed("campaign.toml", old, new)
    refused(f"campaign.toml: {message}", load_campaign, path)


WHOLE_FILES_REFUSED = {
    "no record": (
        'mechanism = "mechanism.toml"\n',
        "no record; write one [[record]] table for each measured file",
    ),
    "record in single brackets": (
        'mechanism = "mechanism.toml"\n[record]\nname = "a"\n',
        "record: found a table; write each as a table under [[record]]",
    ),
}


@pytest.mark.parametrize("name", WHOLE_FILES_REFUSED)
def test_a_file_without_records(name, folder):
    content, message = WHOLE_FILES_REFUSED[name]
    (folder / "campaign.toml").write_text(content)
    with pytest.raises(InputFileError, match=f"^{re.escape(f'campaign.toml: {message}')}$"):
        load_campaign(folder)


def test_a_path_with_backslashes_is_said_to_need_slashes(changed):
    path = changed("campaign.toml", '"full_46.csv"', '"data\\xfull_46.csv"')
    with pytest.raises(InputFileError, match=r"; write paths with /, as \"data/run\.csv\"$"):
        load_campaign(path)
