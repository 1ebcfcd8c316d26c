"""What begins or surrounds a job: demo, new files, equations, the explorer. Truth: what the commands do and leave."""

import json

import pytest

import mechid


def test_new_files_name_the_records(tmp_path):
    written = mechid.new_campaign(tmp_path / "mine", ["one.csv"], "brushed_dc_drive")
    assert [path.name for path in written] == ["mechanism.toml", "campaign.toml"]
    assert 'name = "one"' in written[1].read_text()


@pytest.mark.slow
def test_the_demo_finds_what_made_it(tmp_path):
    """Truth: truth.json of the bench."""
    done = mechid.demo(tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())
    off = {name: done.fit.parameters[name] for name in ("gear.stiffness", "stepper.torque_constant")}
    assert all(abs(p.value - truth[name]) < 4.0 * p.std_error for name, p in off.items())
    assert (tmp_path / "report.html").is_file()
