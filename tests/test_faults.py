"""The driver of faults sees a fault. Truth: faults made by hand."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

from faults.layers import with_layer
from faults.reference import half_written, numbers, unexpected

RENAMES = """
import os, sys
from pathlib import Path
for k in range(1, 5):
    beside, place = Path(sys.argv[1]) / f".a{k}.json.7.part", Path(sys.argv[1]) / f"a{k}.json"
    beside.write_text("1")
    try:
        beside.replace(place)
        print(k, "renamed")
    except OSError as error:
        print(k, error.strerror)
"""
CLOCK = """
import datetime, time
before, real = time.time(), time.monotonic()
while time.monotonic() - real < 0.6:
    pass
after = datetime.datetime.now(datetime.UTC)
print(round(after.timestamp() - before))
"""


def said(script, fault, *arguments):
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.run(command, env=with_layer(fault), capture_output=True, text=True, check=True).stdout.split("\n")


def test_the_rename_that_is_asked_for_fails_alone(tmp_path):
    assert said(RENAMES, "rename:3", tmp_path)[:4] == ["1 renamed", "2 renamed", "3 Stale file handle", "4 renamed"]


def test_the_clock_goes_back_by_an_hour_when_asked():
    assert said(CLOCK, "clock:0.3")[0] in ("-3599", "-3600")
    assert said(CLOCK, "clock:60")[0] in ("0", "1")


def test_other_numbers_are_seen_and_other_times_are_not(tmp_path):
    whole = {"parameters": {"a": {"value": 0.1}}, "stages": [{"seconds": 1.0}], "provenance": {"wall_time_s": 2.0}}
    told = []
    for value, seconds in ((0.1, 1.0), (0.1, 9.0), (0.1 + 1e-17 + 1.4e-17, 1.0)):
        whole["parameters"]["a"]["value"], whole["stages"][0]["seconds"] = value, seconds
        (tmp_path / "estimate.json").write_text(json.dumps(whole))
        told.append(numbers(tmp_path, "identify"))
    assert told[0] == told[1] != told[2]


def test_what_is_half_written_and_what_nobody_should_see_is_named(tmp_path):
    (tmp_path / "budget.json").write_text('{"a": 1')
    (tmp_path / "estimate.json").write_text('{"a": 1}')
    assert half_written(tmp_path) == ["half-written: budget.json"]
    assert unexpected("Traceback (most recent call last):\nmechid: unexpected error, please") == [
        "said: Traceback",
        "said: unexpected error",
    ]


def test_the_table_counts_what_was_as_promised():
    path = Path(__file__).parents[1] / "benchmarks" / "faults.py"
    spec = importlib.util.spec_from_file_location("driver_of_faults", path)
    driver = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(driver)
    lines = [{"scenario": "kill", "faults": []}, {"scenario": "kill", "faults": ["other numbers"]}]
    assert driver.table(lines).splitlines()[1].split() == ["kill", "2", "1"]
