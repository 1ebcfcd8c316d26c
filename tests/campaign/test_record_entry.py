"""One record of a campaign file. Truth: the campaign contract, and a line with place and remedy for each fault."""

import pytest

from mechid.campaign import load_campaign
from mechid.records import ChannelSpec

NAME = 'name = "full_46"'
COMMAND = 'command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }'

REFUSED = {
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
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_entry_says_where_what_and_the_remedy(name, changed, refused):
    old, new, message = REFUSED[name]
    path = changed("campaign.toml", old, new)
    refused(f"campaign.toml: {message}", load_campaign, path)


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
