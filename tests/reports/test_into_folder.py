"""What an identification leaves in a folder. Truth: the files that are there before and after."""

import shutil
from dataclasses import replace

import pytest

from mechid.campaign import catalogue_mechanism, load_campaign, mechanism_text
from mechid.campaign.bench import write_bench
from mechid.reports.into_folder import identification_inputs, mechanism_name
from mechid.reports.results import ESTIMATED


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return load_campaign(write_bench(tmp_path_factory.mktemp("bench"), seed=3, sweep_s=0.2))


def test_a_mechanism_written_by_hand_keeps_its_name(campaign, tmp_path):
    """Truth: the files; beside its campaign, or over a file of somebody else, the estimate has another name."""
    assert mechanism_name(campaign, tmp_path) == "mechanism.toml"
    assert mechanism_name(campaign, campaign.mechanism_path.parent) == "mechanism_estimated.toml"
    (tmp_path / "mechanism.toml").write_text(mechanism_text(catalogue_mechanism(), "by hand"), encoding="utf-8")
    assert mechanism_name(campaign, tmp_path) == "mechanism_estimated.toml"
    (tmp_path / "mechanism.toml").write_text(f"# {ESTIMATED} by mechid\n", encoding="utf-8")
    assert mechanism_name(campaign, tmp_path) == "mechanism.toml"


def test_a_journal_knows_its_inputs(campaign, tmp_path):
    """Truth: a copy of the files, another seed, and a record of which one sample differs."""
    inputs = identification_inputs(campaign, 0)
    copied = load_campaign(shutil.copytree(campaign.path.parent, tmp_path / "copy"))
    assert identification_inputs(copied, 0) == inputs
    assert identification_inputs(campaign, 1) != inputs
    record = campaign.records[0]
    torque = record.data.channels[0]
    data = torque.data[:].copy()
    data[7] += 1e-9
    other = replace(record, data=replace(record.data, channels=(replace(torque, data=data),)))
    changed = replace(campaign, records=(other, *campaign.records[1:]))
    assert identification_inputs(changed, 0) != inputs
