"""The demo from Python. Truth: what made its records."""

import json

import pytest

import mechid


@pytest.mark.slow
def test_the_demo_finds_what_made_it(tmp_path):
    """Truth: truth.json of the bench."""
    done = mechid.demo(tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())
    off = {name: done.fit.parameters[name] for name in ("gear.stiffness", "stepper.torque_constant")}
    assert all(abs(p.value - truth[name]) < 4.0 * p.std_error for name, p in off.items())
    assert (tmp_path / "report.html").is_file()
