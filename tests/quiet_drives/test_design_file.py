"""quiet.toml. Truth: the keys of docs/quiet.md, and limits that nobody can keep."""

import pytest

from mechid.errors import InputFileError
from mechid.quiet_drives.design_file import QuietDesign, quiet_design_of, read_quiet_file


def test_an_empty_file_is_the_default(tmp_path):
    (tmp_path / "quiet.toml").write_text("")
    assert read_quiet_file(tmp_path / "quiet.toml") == QuietDesign()


def test_the_loops_of_the_same_file_are_checked_and_left_to_the_linear_export():
    """Truth: the example of docs/export_loops.md."""
    loop = {"kp": 100.0, "ki": 20000.0, "sample_rate_hz": 10000.0}
    assert quiet_design_of({"current_loop": loop}) == QuietDesign()
    with pytest.raises(InputFileError, match=r"current_loop\.gain: unknown key"):
        quiet_design_of({"current_loop": {**loop, "gain": 1.0}})


def test_all_keys_are_read():
    found = quiet_design_of(
        {
            "rates": [30.0, 46],
            "orders": [0.5, 1.0],
            "range": {"from": 10, "to": 120},
            "microsteps": 32,
            "bits": 8,
            "steppings": ["micro", "full"],
            "mean_rates": [40.0],
            "seed": 3,
            "drive": {"peak": 1.1, "pull_out_share": 0.8},
            "limit": {"rms_Nm": 0.01},
            "flight": {"load_inertia": 0.5},
        }
    )
    assert (found.rates, found.orders, found.ends) == ((30.0, 46.0), (0.5, 1.0), (10.0, 120.0))
    assert (found.microsteps, found.bits, found.steppings, found.mean_rates) == (32, 8, ("full", "micro"), (40.0,))
    assert (found.seed, found.peak, found.pull_out_share, found.rms_limit) == (3, 1.1, 0.8, 0.01)


@pytest.mark.parametrize(
    ("table", "place", "remedy"),
    [
        ({"bits": 3}, "bits", "from 4 to 16"),
        ({"bits": 17}, "bits", "from 4 to 16"),
        ({"bits": 8.0}, "bits", "whole number"),
        ({"bit": 8}, "bit", "bits"),
        ({"drive": {"peak": 0.9}}, "drive.peak", "the nominal sine already reaches 1"),
        ({"drive": {"pull_out_share": 1.2}}, "drive.pull_out_share", "up to 1"),
        ({"range": {"from": 10.0}}, "range.to", "missing"),
        ({"range": {"from": 20.0, "to": 10.0}}, "range", "lower rate first"),
        ({"rates": [5.0], "range": {"from": 10.0, "to": 20.0}}, "rates[0]", "outside range 10 to 20"),
        ({"rates": 30.0}, "rates", "write numbers"),
        ({"rates": [-30.0]}, "rates[0]", "above 0"),
        ({"steppings": ["quarter"]}, "steppings[0]", "full"),
        ({"microsteps": 1}, "microsteps", "from 2 to 256"),
        ({"limit": {"rms": 1.0}}, "limit.rms", "rms_Nm"),
        ({"drive": 1.0}, "drive", "write a table"),
    ],
)
def test_a_wrong_entry_is_named_with_its_remedy(table, place, remedy):
    with pytest.raises(InputFileError) as error:
        quiet_design_of(table)
    assert str(error.value).startswith(f"quiet.toml: {place}: ")
    assert remedy in str(error.value)
