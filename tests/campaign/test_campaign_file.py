"""The campaign file: what it may say, and a message for each way it can be wrong."""

import re

import pytest

from mechid.campaign import Match, load_campaign
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, RecordError
from mechid.parameter import Status
from mechid.records import ChannelSpec


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


def test_options_of_a_record(changed):
    more = """offset = false
drift = false
sample_rate_hz = 1000
channels = [
  { quantity = "current_phase_a", column = 0, unit = "mA" },
  { quantity = "torque", column = "torque", unit = "N*m", gain = -2 },
]
command"""
    record = load_campaign(changed("campaign.toml", "command", more)).record("full_46")
    assert record.spec.sample_rate_hz == 1000.0
    assert [(m.quantity, m.offset, m.drift) for m in record.matches] == [
        ("torque", False, False),
        ("current_phase_a", False, False),
    ]
    assert record.spec.channels == (
        ChannelSpec(quantity="current_phase_a", column=0, unit="mA"),
        ChannelSpec(quantity="torque", column="torque", unit="N*m", gain=-2.0),
    )


def test_files_are_relative_to_the_campaign(folder, monkeypatch):
    (folder / "data").mkdir()
    (folder / "full_46.csv").rename(folder / "data" / "full_46.csv")
    content = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(content.replace('"full_46.csv"', '"data/full_46.csv"'))
    monkeypatch.chdir(folder / "data")
    assert load_campaign("../campaign.toml").record("full_46").data.samples == 1001


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
COMMAND = 'command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }'
TORQUE = '{ quantity = "torque", column = "Mz" }'

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
    "unknown key": (NAME, f"{NAME}\nofset = false", 'record[0].ofset: unknown key; did you mean "offset"?'),
    "no name": (NAME, "", 'record[0].name: missing; write a name, as name = "full_46"'),
    "name that is no file name": (
        NAME,
        'name = "full 46/1"',
        'record[0].name: found "full 46/1"; write letters, digits, _ and - only: it becomes a file name',
    ),
    "name of a wrong type": (
        NAME,
        "name = 46",
        "record[0].name: found 46; write letters, digits, _ and - only: it becomes a file name",
    ),
    "same name": (
        NAME,
        'name = "sweep"',
        'record[1].name: "sweep" is also the name of record[0]; give each record its own',
    ),
    "same name but for the case": (
        NAME,
        'name = "Sweep"',
        'record[1].name: "sweep" is but for capitals the name of record[0]; give each record its own',
    ),
    "no file": (
        'file = "full_46.csv"',
        "",
        'record[0].file: missing; write the name of the measured file, as file = "full_46.csv"',
    ),
    "file of a wrong type": (
        'file = "full_46.csv"',
        "file = true",
        'record[0].file: found true; write the name of the measured file, as file = "full_46.csv"',
    ),
    "no command": (
        COMMAND,
        "",
        'record[0].command: missing; write how the motor was driven, as command = { stepping = "full", rate = 46.0 }',
    ),
    "fault of a command": (
        "rate = 46.0",
        "rte = 46.0",
        'record[0].command.rte: unknown key; did you mean "rate"?',
    ),
    "too many steps": (
        "rate = 46.0",
        "rate = 1e12",
        "record[0].command: 1e+12 steps in 1.0 s, more than 20000000; check the rate (full steps/s)",
    ),
    "unknown use": (
        '"validate"',
        '"validation"',
        'record[1].use: found "validation"; did you mean "validate"?',
    ),
    "use of a wrong type": (
        '"validate"',
        "true",
        'record[1].use: found true; write one of "estimate", "validate"',
    ),
    "offset that is no boolean": (
        NAME,
        f"{NAME}\noffset = 0.1",
        "record[0].offset: found 0.1; write true or false",
    ),
    "drift that is no boolean": (
        NAME,
        f'{NAME}\ndrift = "no"',
        'record[0].drift: found "no"; write true or false',
    ),
    "rate of zero": (
        NAME,
        f"{NAME}\nsample_rate_hz = 0",
        "record[0].sample_rate_hz: found 0; write the samples per second, above 0",
    ),
    "rate with a unit": (
        NAME,
        f'{NAME}\nsample_rate_hz = "10 kHz"',
        'record[0].sample_rate_hz: found "10 kHz"; write the number alone in Hz, without quotes',
    ),
    "time offset without bounds": (
        "{ value = 0.0, min = -0.002, max = 0.002 }",
        "{ value = 0.0 }",
        "record[1].time_offset_s.min: missing, and record time at which the command starts "
        "has no physical limit there; write { value = ..., min = ..., max = ... }",
    ),
    "channels of a wrong type": (
        NAME,
        f'{NAME}\nchannels = "Mz"',
        f'record[0].channels: found "Mz"; write a list of tables, as [{TORQUE}]',
    ),
    "no channels": (
        NAME,
        f"{NAME}\nchannels = []",
        f"record[0].channels: found []; write a list of tables, as [{TORQUE}]",
    ),
    "unknown quantity": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torqe", column = "Mz" }}]',
        'record[0].channels[0].quantity: found "torqe"; did you mean "torque"?',
    ),
    "time as a channel": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "time", column = "t" }}]',
        'record[0].channels[0].quantity: found "time"; write one of "torque", ',
    ),
    "no quantity": (
        NAME,
        f'{NAME}\nchannels = [{{ column = "Mz" }}]',
        'record[0].channels[0].quantity: missing; write what it is, as quantity = "torque"',
    ),
    "no column": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque" }}]',
        f"record[0].channels[0].column: missing; write {TORQUE}",
    ),
    "column of a wrong type": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = -1 }}]',
        "record[0].channels[0].column: found -1; write the column's name or path, or its index from 0",
    ),
    "unit of something else": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", unit = "V" }}]',
        'record[0].channels[0].unit: unit "V" does not measure torque; expected N*m or a multiple of it',
    ),
    "gain of zero": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", gain = 0.0 }}]',
        "record[0].channels[0].gain: found 0; it would erase the channel, write -1.0 to reverse its sign",
    ),
    "gain that is not finite": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", gain = inf }}]',
        "record[0].channels[0].gain: found inf; write a finite number",
    ),
    "unknown role": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", role = "outptu" }}]',
        'record[0].channels[0].role: found "outptu"; did you mean "output"?',
    ),
    "input": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", role = "input" }}]',
        "record[0].channels: nothing but inputs; name what the model is to match",
    ),
    "input that drives nothing": (
        NAME,
        f'{NAME}\nchannels = [{TORQUE}, {{ quantity = "force", column = "F", role = "input" }}]',
        'record[0].command.stepping: the record is driven by its channels of role = "input" (force); leave one out',
    ),
    "between without input": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", between = "held" }}]',
        "record[0].channels[0].between: it says how an input runs between samples",
    ),
    "no torque": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "force", column = "Fz" }}]',
        "record[0].channels: force: the mechanism gives torque, rotor_angle, rotor_rate, output_angle, ",
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
