"""A campaign made in code, written as files. Truth: the campaign that was written, samples to the last bit."""

import numpy as np
import pytest

import mechid
from samples_in_memory import COMMAND, SOURCES


@pytest.mark.parametrize("source", SOURCES)
def test_a_campaign_in_memory_is_the_same_in_files(source, tmp_path):
    """Truth: the campaign that was written, samples to the last bit."""
    entries = {
        "stage": [{"records": ["a"], "window_s": [0.0, 0.2], "free": ["gear.stiffness"]}],
        "identify": {"colour": "none"},
    }
    planned = mechid.make_record(
        "b",
        command=mechid.make_command("micro", microsteps=16, rate=[[0.0, 0.0], [2.0, 60.0]], clock_tick_s=1e-4),
        use="validate",
        entries={"time_offset_s": {"value": 0.0, "min": -1e-3, "max": 1e-3}},
    )
    made = mechid.make_campaign(mechid.catalogue_mechanism(), [SOURCES[source](), planned], entries=entries)
    files = mechid.write_campaign(made, tmp_path / "bench")
    assert sorted(file.name for file in files) == ["a.csv", "campaign.toml", "mechanism.toml"]
    read = mechid.load_campaign(tmp_path / "bench", need_files=False)
    assert read.parameters == made.parameters
    assert [r.command for r in read.records] == [r.command for r in made.records]
    assert (read.stages, read.options, read.warnings) == (made.stages, made.options, made.warnings)
    one, other = read.records[0].data, made.records[0].data
    assert one.sample_rate_hz == pytest.approx(other.sample_rate_hz, rel=1e-12)
    assert np.array_equal(one.channel("torque").data[:], other.channel("torque").data[:])


def test_a_campaign_is_written_once_and_only_where_it_is_in_no_file(tmp_path):
    made = mechid.make_campaign(mechid.catalogue_mechanism(), [mechid.make_record("a", command=COMMAND)])
    mechid.write_campaign(made, tmp_path)
    with pytest.raises(mechid.UsageError, match=r"campaign.toml: already exists; give another folder"):
        mechid.write_campaign(made, tmp_path)
    with pytest.raises(mechid.UsageError, match="in files already"):
        mechid.write_campaign(mechid.load_campaign(tmp_path, need_files=False), tmp_path / "other")
