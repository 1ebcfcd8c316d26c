"""The synthetic bench; truth: its definition in the issue, and the values that it says it was made from."""

import json

import numpy as np
import pytest

import paper
from mechid.campaign import load_campaign, load_mechanism
from mechid.campaign.bench import NOISE_NM, TRUTH, bench_records, true_mechanism, write_bench
from mechid.campaign.prediction import simulate_all


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_bench(tmp_path_factory.mktemp("bench"), seed=11, sweep_s=2.0).parent


def test_the_truth_is_the_papers_estimate_with_detent_phases():
    mechanism = true_mechanism()
    assert {name: mechanism.value(name) for name in paper.ESTIMATED} == dict(paper.ESTIMATED)


def test_it_is_the_bench_of_the_issue():
    campaign = {record.name: record for record in bench_records()}
    assert list(campaign) == ["full_23", "full_46", "full_92", "micro_23", "micro_46", "micro_92", "sweep"]
    assert campaign["sweep"].duration_s == 60.0
    assert "[60.0, 120.0]" in campaign["sweep"].command


def test_it_says_that_it_is_synthetic(folder):
    for name in ("campaign.toml", "mechanism.toml"):
        assert (folder / name).read_text().startswith("# SYNTHETIC")


def test_the_mechanism_file_holds_the_catalogue_and_not_the_truth(folder):
    mechanism = load_mechanism(folder / "mechanism.toml")
    assert {q.name for q in mechanism.free} == set(TRUTH)
    assert mechanism.value("gear.stiffness") == 2200.0
    assert json.loads((folder / "truth.json").read_text()) == dict(TRUTH)


def test_the_records_are_the_truths_torque_with_noise_offset_and_drift(folder):
    campaign = load_campaign(folder)
    assert campaign.warnings == ()
    from dataclasses import replace

    exact = simulate_all(replace(campaign, mechanism=true_mechanism()))
    for record in campaign.records:
        measured = record.data.channel("torque").data
        residual = measured - exact[record.name].torque
        line = np.polynomial.Polynomial.fit(exact[record.name].time, residual, 1)(exact[record.name].time)
        assert np.std(residual - line) == pytest.approx(NOISE_NM, rel=0.05)
        assert 1e-5 < abs(line[0]) < 0.05
        assert record.data.sample_rate_hz == 10_000.0


def test_a_seed_makes_the_same_files_and_another_seed_others(folder, tmp_path):
    same, other = write_bench(tmp_path / "a", seed=11, sweep_s=2.0), write_bench(tmp_path / "b", seed=12, sweep_s=2.0)
    name = "full_46.csv"
    assert (same.parent / name).read_bytes() == (folder / name).read_bytes()
    assert (other.parent / name).read_bytes() != (folder / name).read_bytes()
