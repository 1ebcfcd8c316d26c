"""The ``conditioning`` and ``time`` of a record. Truth: the file as written, and the whole record."""

import numpy as np
import pytest

from mechid.campaign import load_campaign
from mechid.campaign.conditioning_entry import read_conditioning
from mechid.campaign.place import Place
from mechid.campaign.prediction import simulate
from mechid.errors import InputFileError
from mechid.records import Conditioning, TimeStamps

PLACE = Place("campaign.toml").key("record").item(0).key("conditioning")
TORQUE = ("torque",)


def test_every_key_is_read():
    entry = {
        "time_stamps": "regular",
        "limits": {"torque": [-5, 5.0]},
        "max_gap_s": 0.002,
        "cumulate": ["torque"],
        "quiet_s": {"torque": [[0.0, 0.5], [9.5, 10]]},
        "window_s": [1.0, 9],
        "decimate": 5,
    }
    assert read_conditioning(entry, PLACE, TORQUE) == Conditioning(
        time_stamps=TimeStamps.REGULAR,
        limits={"torque": (-5.0, 5.0)},
        max_gap_s=0.002,
        cumulate=("torque",),
        quiet_s={"torque": ((0.0, 0.5), (9.5, 10.0))},
        window_s=(1.0, 9.0),
        decimate=5,
    )


def test_no_entry_is_no_conditioning():
    assert read_conditioning(None, PLACE, TORQUE) == Conditioning()


WRONG = {
    "no table": (5, "conditioning: found 5; write a table"),
    "unknown key": ({"windw_s": [0, 1]}, 'conditioning.windw_s: unknown key; did you mean "window_s"?'),
    "window back": ({"window_s": [2.0, 1.0]}, "conditioning.window_s: found [2.0, 1.0]; the second has to be above"),
    "window of one": ({"window_s": [2.0]}, "conditioning.window_s: found [2.0]; write [from, to] in s"),
    "window of texts": ({"window_s": ["a", 1.0]}, 'conditioning.window_s[0]: found "a"; write the number alone in s'),
    "decimate by half": ({"decimate": 0.5}, "conditioning.decimate: found 0.5; write a whole number from 1 to 1000"),
    "no gap": ({"max_gap_s": 0.0}, "conditioning.max_gap_s: found 0.0; write the longest gap"),
    "limits alone": (
        {"limits": {"torque": [-1, 1]}},
        "conditioning.limits: samples on or beyond the limits count as missing",
    ),
    "limits of nothing": (
        {"limits": {"torqe": [-1, 1]}, "max_gap_s": 1.0},
        'conditioning.limits.torqe: unknown key; did you mean "torque"?',
    ),
    "limits of a number": ({"limits": 5.0, "max_gap_s": 1.0}, "conditioning.limits: found 5.0; write a table"),
    "quiet stretch": ({"quiet_s": {"torque": []}}, "conditioning.quiet_s.torque: found []; write a list of stretches"),
    "increments of nothing": ({"cumulate": ["torqe"]}, "conditioning.cumulate[0]: "),
    "increments": ({"cumulate": True}, "conditioning.cumulate: found true; write a list of quantities"),
    "time stamps": ({"time_stamps": "jittered"}, "conditioning.time_stamps: found"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_entry_says_where_what_and_the_remedy(name):
    entry, says = WRONG[name]
    with pytest.raises(InputFileError) as caught:
        read_conditioning(entry, PLACE, TORQUE)
    assert f"campaign.toml: record[0].{says}" in str(caught.value)


@pytest.fixture
def conditioned(folder):
    """Return a function that adds lines to the first record of a campaign, and loads it."""

    def load(lines):
        path = folder / "campaign.toml"
        path.write_text(path.read_text().replace("[[record]]", f"[[record]]\n{lines}", 1))
        return load_campaign(path)

    return load


def test_a_window_of_a_record_is_simulated_from_the_commands_start(conditioned, folder):
    """Truth: the same samples of the whole record's simulation."""
    whole = simulate(load_campaign(folder / "campaign.toml"), "full_46").torque
    campaign = conditioned("conditioning = { window_s = [0.2, 0.5] }")
    assert campaign.warnings == ()
    part = simulate(campaign, "full_46").torque
    np.testing.assert_allclose(part, whole[200:501], atol=2e-5 * np.sqrt(np.mean(whole**2)))


def test_the_time_column_may_be_named(conditioned):
    campaign = conditioned('time = { column = 0, unit = "s" }\nchannels = [{ quantity = "torque", column = 1 }]')
    assert campaign.record("full_46").data.sample_rate_hz == 1000.0


def test_a_time_that_is_no_table_is_refused(conditioned):
    with pytest.raises(InputFileError, match=r"record\[0\].time: found 3; write a table"):
        conditioned("time = 3")


def test_parts_of_one_file_are_no_doubles(conditioned, folder):
    (folder / "sweep.csv").write_bytes((folder / "full_46.csv").read_bytes())
    assert any("is the same file as that of" in line for line in load_campaign(folder / "campaign.toml").warnings)
    campaign = conditioned("conditioning = { window_s = [0.2, 0.5] }")
    assert not any("is the same file as that of" in line for line in campaign.warnings)
