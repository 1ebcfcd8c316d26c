"""The numbers of a look. Truth: what the test has put into the records."""

import json

import numpy as np
import pytest

from look_records import HUM, HUM_HZ, LINES, NOISE, STEPS
from mechid.looks.numbers import FORMAT


def test_what_was_put_in_is_found_with_its_error(looked):
    data = json.loads((looked[0] / "look.json").read_text())
    assert data["format"] == FORMAT == "mechid-look/1"
    record = data["records"][0]
    assert record["driven"]["suggested"]["rates"][0] == pytest.approx(STEPS, abs=0.01)
    channel = next(c for c in record["channels"] if c["quantity"] == "torque")
    lines = {line["order"]: line for line in channel["lines"] if line["order"]}
    for order, amplitude in LINES.items():
        assert lines[order]["amplitude"] == pytest.approx(amplitude, abs=5.0 * lines[order]["sigma"] + 1e-3 * amplitude)
    (hum,) = channel["mains"]
    assert (hum["mains_hz"], hum["order"]) == (HUM_HZ, None)
    assert hum["amplitude"] == pytest.approx(HUM, abs=5.0 * hum["sigma"])
    assert channel["noise"]["sigma"] == pytest.approx(NOISE, rel=0.05)


def test_gaps_and_clipping_are_counted(looked):
    (channel,) = json.loads((looked[0] / "look.json").read_text())["records"][1]["channels"]
    assert (channel["gaps"]["count"], channel["gaps"]["samples"]) == (1, 20)
    assert channel["gaps"]["first_at_s"] == [pytest.approx(2.5)]
    assert channel["clipped"]["count"] > 20


def test_third_octaves_and_what_is_below_make_up_the_rms(looked):
    """Parseval, within what the ends of a record's segments weigh less."""
    for record in json.loads((looked[0] / "look.json").read_text())["records"]:
        for channel in record["channels"]:
            if channel["quantity"] == "torque":
                total = sum(band["rms"] ** 2 for band in channel["third_octaves"]) + channel["below_rms"] ** 2
                assert np.sqrt(total) == pytest.approx(channel["rms"], rel=0.01)
