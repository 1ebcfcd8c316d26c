"""Declared emission campaigns. Truth: the files that were written."""

import hashlib

import numpy as np

from emission_bench import background, record, requirement, samples, write_campaign
from mechid.emissions.declared import load_declared


def test_the_files_of_a_bench_are_among_the_inputs_and_its_records_calibrated(tmp_path):
    """Truth: twice the samples of the file, by a calibration of 2 N/N."""
    runs = {"run": samples(1, seconds=4.0), "off": samples(2, seconds=4.0)}
    write_campaign(tmp_path, runs, record("run", 46.0), background(), requirement())
    np.savetxt(tmp_path / "c.csv", 2.0 * np.eye(6), delimiter=",")
    units = 'input_unit = ["N", "N*m"], output_unit = ["N", "N*m"], uncertainty_percent = 0.3'
    text = (tmp_path / "campaign.toml").read_text()
    declared = f'[0.0, 0.0, 0.0]\ncalibration = {{ file = "c.csv", {units} }}\n'
    (tmp_path / "campaign.toml").write_text(text.replace("[0.0, 0.0, 0.0]\n", declared, 1))
    found = load_declared(tmp_path, None)
    assert set(found.inputs) == {"campaign.toml", "c.csv"}
    assert found.inputs["c.csv"] == hashlib.sha256((tmp_path / "c.csv").read_bytes()).hexdigest()
    (run,) = found.read()
    np.testing.assert_allclose(run.data.channel("force_y").data, 2.0 * runs["run"][:, 1])
    np.testing.assert_allclose(found.backgrounds[0].samples("mz"), 2.0 * runs["off"][:, 5])
