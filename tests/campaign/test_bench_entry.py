"""The [bench] table and the channels beside the torque: what is read, and what is refused with its place."""

import numpy as np
import pytest

from mechid.campaign import load_campaign
from mechid.errors import InputFileError, RecordError
from mechid.records import Role

CHANNELS = """[
  { quantity = "torque", column = "Mz", unit = "N*m" },
  { quantity = "force_x", column = "Fx", unit = "mN" },
  { quantity = "force_y", column = "Fy", unit = "N" },
  { quantity = "moment_x", column = "Mx", unit = "N*m" },
]"""
BENCH = '[bench]\ndrive_axis = "z"\nmounting_point_m = [0.1, 0.0, 0.0]\n'
COLUMNS = ("time_s", "Fx", "Fy", "Fz", "Mx", "Mz")


@pytest.fixture
def campaign(tmp_path, mechanism_file):
    """Return a function that loads a campaign of one record with these channels and this end of its file."""
    rng = np.random.default_rng(0)
    rows = np.column_stack([np.arange(200) * 1e-3, rng.normal(size=(200, 5))])
    np.savetxt(tmp_path / "r.csv", rows, delimiter=",", header=",".join(COLUMNS), comments="", fmt="%.17g")

    def load(channels=CHANNELS, end=BENCH, more=""):
        text = (
            f'mechanism = "{mechanism_file.name}"\n[[record]]\nname = "r"\nfile = "r.csv"\n'
            f'command = {{ stepping = "full", rate = 46.0 }}\nchannels = {channels}\n{more}\n{end}'
        )
        (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
        return load_campaign(tmp_path), rows

    return load


@pytest.fixture
def mechanism_file(tmp_path):
    from mechid.campaign import catalogue_mechanism, mechanism_text

    path = tmp_path / "mechanism.toml"
    path.write_text(mechanism_text(catalogue_mechanism()), encoding="utf-8")
    return path


def test_channels_beside_the_torque(campaign):
    """Truth: the columns, in SI, and statics: the torque about a point 0.1 m along x is less by 0.1 m times Fy."""
    loaded, rows = campaign()
    data = loaded.records[0].data
    assert [m.quantity for m in loaded.records[0].matches] == ["torque"]
    assert [c.role for c in data.channels] == [Role.OUTPUT, *[Role.SIDE] * 3]
    np.testing.assert_allclose(data.channel("force_x").data, 1e-3 * rows[:, 1])
    np.testing.assert_allclose(data.channel("torque").data, rows[:, 5] - 0.1 * rows[:, 2], rtol=1e-12)
    np.testing.assert_allclose(data.channel("moment_x").data, rows[:, 4])
    assert not [line for line in loaded.warnings if "not used" in line]


def entry(quantity, column="Fz", more=""):
    return f'[ {{ quantity = "torque", column = "Mz" }}, {{ quantity = "{quantity}", column = "{column}"{more} }} ]'


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"end": ""}, r"record\[0\]\.channels\[1\]: force_x needs the frame of the table and the mounting point"),
        ({"end": '[bench]\ndrive_axis = "z"\n'}, "bench.mounting_point_m: missing; write three numbers in m"),
        ({"end": "[bench]\nmounting_point_m = [0.0, 0.0, 0.0]\n"}, "bench.drive_axis: missing"),
        ({"end": BENCH.replace('"z"', '"w"')}, 'bench.drive_axis: found "w"; write one of'),
        ({"end": BENCH.replace("0.1, 0.0, 0.0", "0.1, 0.0")}, "bench.mounting_point_m: found .*write three numbers"),
        ({"end": BENCH.replace("0.1, 0.0, 0.0", '0.1, "5 mm", 0.0')}, r"_m\[1\]: found \"5 mm\"; write the"),
        ({"end": BENCH + "offset = 1\n"}, "bench.offset: unknown key"),
        ({"end": BENCH.replace('"z"', '"x"')}, r"channels\[3\]: moment_x is the drive torque; write quantity"),
        (
            {
                "end": BENCH.replace("0.1, 0.0, 0.0", "0.0, 0.0, 0.1"),
                "channels": CHANNELS.replace("force_y", "force_z"),
            },
            r"channels\[3\]: moment_x about the mounting point takes force_y too, by the lever arm",
        ),
        (
            {"channels": CHANNELS.replace("force_y", "force_z")},
            r"channels\[0\]: torque about the mounting point takes force_y too.*add the channel$",
        ),
        (
            {"channels": entry("force_z", more=', unit = "N", role = "input"')},
            "role: force_z is measured in addition to the torque and has no role",
        ),
        (
            {"channels": entry("force_z", more=', unit = "N", noise_sigma = 1.0')},
            "noise_sigma: applies to outputs only, and this is a component",
        ),
        ({"channels": entry("force_z", more=', unit = "N*m"')}, 'unit "N.m" does not measure force_z; expected N'),
        (
            {"channels": '[ { quantity = "force_z", column = "Fz", unit = "N" } ]'},
            "only components beside the torque",
        ),
    ],
)
def test_wrong_entries_are_one_line_with_their_place(campaign, changed, said):
    with pytest.raises(InputFileError, match=said):
        campaign(**changed)


def test_a_component_without_a_unit_is_refused(campaign):
    """Nothing else of the record would show a wrong one; the torque without one is in SI, as ever."""
    flat = BENCH.replace("0.1, 0.0, 0.0", "0.0, 0.0, 0.1")
    with pytest.raises(RecordError, match=r'r\.csv: force_z: column "Fz" states no unit; write unit = "N"'):
        campaign(channels=entry("force_z"), end=flat)
    loaded, _ = campaign(channels=entry("force_z", more=', unit = "N"'), end=flat)
    assert loaded.records[0].data.channel("force_z").unit == "N"


def test_records_of_different_components_are_refused(campaign):
    more = (
        '[[record]]\nname = "s"\nfile = "r.csv"\ncommand = { stepping = "full", rate = 46.0 }\n'
        "channels = " + entry("force_z", more=', unit = "N"') + "\n"
    )
    with pytest.raises(InputFileError, match=r"record\[1\]\.channels: .*force_z.* in one of it and record\[0\] alone"):
        campaign(more=more, end=BENCH.replace("0.1", "0.0"))


def test_a_bench_without_components_changes_nothing(campaign):
    """Truth: the file's column. A record of the torque alone cannot be moved, and stays as it is."""
    loaded, rows = campaign(channels='[ { quantity = "torque", column = "Mz" } ]')
    np.testing.assert_array_equal(loaded.records[0].data.channel("torque").data, rows[:, 5])
