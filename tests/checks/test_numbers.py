"""The overview of a campaign. Truth: the bench's own definition, and noise of a known level."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import LAYOUTS, changed, paper_with
from mechid.campaign import load_campaign
from mechid.campaign.bench import write_bench
from mechid.checks.document import PRESENTER
from mechid.checks.numbers import check_numbers
from mechid.identification.output_error.noise_level import known_noise
from printing import printed, tables


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return load_campaign(write_bench(tmp_path_factory.mktemp("bench"), seed=5, sweep_s=1.0))


def test_the_overview_says_what_the_files_say(campaign):
    """Truth: the bench's own definition."""
    data = check_numbers(campaign)
    sweep = next(record for record in data["records"] if record["name"] == "sweep")
    assert sweep["samples"] == 10001
    assert sweep["sample_rate_hz"] == 10000.0
    assert sweep["edges"] == 16  # one full step in 1 s of 0 to 2 steps/s, 16 microsteps each
    assert sweep["command"] == "microstepping (16) at 0 to 2 full steps/s over 1 s, from 0 deg"
    assert sweep["noise_sigma"] == pytest.approx(0.002, rel=0.1)
    assert len(data["free"]) == 15


def test_the_lines_of_a_mesh_and_of_a_clock_are_listed(campaign):
    """Truth: teeth by hand: 20 and 20/52 of them per turn; the clock of the drive."""
    limit = LAYOUTS["current limit"]
    chop = {"stepper": {"chop": {"frequency_hz": 2e4}}, "gear": {"ratio": 2.6, "mesh": [{"teeth": [20, 52]}]}}
    data = check_numbers(replace(campaign, mechanism=paper_with(changed(limit, chop))))
    rows = {row["name"]: row["text"] for row in data["named_lines"]}
    assert rows["mesh 1"] == {"per_turn": "20", "order": "0.1", "frequency_hz": ""}
    assert rows["mesh 1 driven"]["per_turn"] == "0.384615"
    assert rows["chopper"] == {"per_turn": "", "order": "", "frequency_hz": "20000"}
    text = printed(PRESENTER.print, data, 80)
    assert all(name in text for name in rows)
    assert max(len(line) for table in tables(text) for line in table) <= 80


def test_the_overview_fits_eighty_columns(campaign):
    data = check_numbers(campaign, ["something is odd"])
    text = printed(PRESENTER.print, data, 80)
    assert max(len(line) for table in tables(text) for line in table) <= 80
    assert "warning: something is odd" in text.splitlines()
    assert all(row["key"] in text and row["text"]["value"] in text for row in data["parameters"])


def test_the_noise_of_the_tables_is_that_of_the_fit_without_bridged_samples(campaign):
    """Truth: white noise of 2 mN m but for a third that stands still, as where a long gap is bridged."""
    entry = next(record for record in campaign.records if record.name == "sweep")
    torque = entry.data.channel("torque")
    bridged = np.arange(4000, 7400)
    noisy = np.random.default_rng(1).normal(0.0, 0.002, torque.data.size)
    noisy[bridged] = 0.0
    gone = replace(entry, data=replace(entry.data, channels=(replace(torque, data=noisy, bridged=bridged),)))
    data = check_numbers(replace(campaign, records=(gone,)))
    assert data["records"][0]["noise_sigma"] == pytest.approx(0.002, rel=0.05)
    assert data["channels"][0]["noise_sigma"] == data["records"][0]["noise_sigma"]
    assert known_noise(gone, gone.estimated[0]).sigma == data["records"][0]["noise_sigma"]
