"""Remedies are offered only where they make a record fit. Truth: how each record was made wrong."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading
from mechid.identification.readings.detectors import declaration_warnings
from mechid.identification.readings.finding import DeclaredRecords
from mechid.identification.readings.misreading import find_misreadings
from mechid.identification.readings.suspicion import Suspicions
from mechid.units import to_si_factor
from paper import constant
from synthetic import COMMANDS, RATE_HZ, campaign, measured, record, truth

REMEDY = re.compile(r"write (rate|time_offset_s|unit|stepping|[\d.e+-]+ times)|trigger|exchange")
FULL = measured(truth(), COMMANDS["full_46"], np.random.default_rng((7, 0)), seconds=1.0)
OTHER = measured(truth(), COMMANDS["micro_46"], np.random.default_rng((7, 2)), seconds=1.0)


def lines(y, *others, rate_hz=RATE_HZ, command=COMMANDS["full_46"]):
    """Return what is said of a record, beside others that are right."""
    return declaration_warnings(campaign(catalogue_mechanism(), record("r", y, command, rate_hz=rate_hz), *others))


def declared(bench):
    """Return the records of a campaign as they are declared."""
    return DeclaredRecords(bench, make_problem(bench, 1))


def with_thousands_commas():
    """Return milli newton metres without decimals, of which 1,025 is read as 1.025."""
    milli = np.round(5e3 * FULL)
    return 1e-3 * np.where(np.abs(milli) >= 1000.0, 1e-3 * milli, milli)


def with_missing_as(value):
    y = FULL.copy()
    y[[5000, 6001, 8888]] = value
    return y


def half_too_small():
    y = FULL.copy()
    y[5000:] *= 1e-3
    return y


def with_two_rates():
    return np.concatenate([FULL[:5000], FULL[5000::2]])


MISREAD = {
    "thousands commas": with_thousands_commas(),
    "raw counts": np.round((FULL - 0.1) / 1e-4),
    "counts of 16 bits wrapped": np.round(FULL / 1e-5).astype(np.int64).astype(np.int16).astype(float),
    "-9999 for missing": with_missing_as(-9999.0),
    "1e10 for missing": with_missing_as(1e10),
    "half a thousand times too small": half_too_small(),
    "backwards": FULL[::-1].copy(),
    "absolute values": np.abs(FULL),
    "rectified and squared": 40.0 * FULL**2,
    "every second sample of another channel": np.where(np.arange(FULL.size) % 2, FULL, 8.0 + FULL),
    "integrated": 300.0 * np.cumsum(FULL) / RATE_HZ,
    "a voltage": 5.0 * np.sin(2.0 * np.pi * 11.5 * np.arange(FULL.size) / RATE_HZ),
}
"""Records in numbers that nobody measured."""


LONG = (
    "thousands commas",
    "integrated",
    "absolute values",
    "counts of 16 bits wrapped",
    "rectified and squared",
    "every second sample of another channel",
    "backwards",
    "half a thousand times too small",
)
"""More than a second each; the default tests have four others."""


@pytest.mark.parametrize("name", [pytest.param(one, marks=pytest.mark.slow) if one in LONG else one for one in MISREAD])
def test_no_remedy_is_offered_for_numbers_that_were_misread(name):
    assert not [line for line in lines(MISREAD[name]) if REMEDY.search(line)]


def test_no_remedy_is_offered_for_a_record_of_two_sample_rates():
    """Truth: the second half has half the rate, and all of it is read at that."""
    assert not [line for line in lines(with_two_rates(), rate_hz=0.5 * RATE_HZ) if REMEDY.search(line)]


@pytest.mark.parametrize(
    "name", [pytest.param("thousands commas", marks=pytest.mark.slow), "half a thousand times too small"]
)
def test_a_misread_record_beside_right_ones_gets_no_remedy(name):
    right = record("other", OTHER, COMMANDS["micro_46"])
    assert not [line for line in lines(MISREAD[name], right) if REMEDY.search(line)]


def test_what_was_seen_is_said_without_a_cause():
    (line,) = lines(MISREAD["raw counts"])
    assert line.startswith("all records: measured torque is far larger")
    assert "check how" in line


@pytest.mark.parametrize("unit", ["mN*m", "N*cm", "ozf*in"])
def test_the_unit_of_all_records_is_the_one_that_fits(unit):
    """Truth: the unit of the numbers; one that is 1.4 times as large does not fit."""
    found = [re.findall(r'unit = "([^"]+)"', line) for line in lines(FULL / to_si_factor(unit, "torque"))]
    assert found == [[unit]]


def test_the_unit_of_one_record_is_the_one_that_fits():
    bench = campaign(
        catalogue_mechanism(),
        record("full_46", FULL / to_si_factor("ozf*in", "torque"), COMMANDS["full_46"]),
        record("micro_46", OTHER, COMMANDS["micro_46"]),
    )
    (finding,) = find_misreadings(declared(bench))
    assert finding.reading["full_46"].scale == pytest.approx(to_si_factor("ozf*in", "torque"))
    assert finding.is_confirmed


def test_a_late_trigger_is_still_named():
    """Truth: the command began 60 ms after the record."""
    y = measured(truth(), COMMANDS["full_46"], np.random.default_rng(3), seconds=1.0, time_offset_s=0.06)
    (line,) = lines(y)
    value = float(re.search(r"value = ([\d.]+)", line)[1])
    assert value == pytest.approx(0.06, abs=1.0 / 46.0)


def test_another_rate_and_stepping_are_still_named():
    (line,) = lines(FULL, command=constant(31.0))
    assert float(re.search(r"write rate = ([\d.]+)", line)[1]) == pytest.approx(46.0, rel=1e-3)
    (line,) = lines(OTHER, record("full_46", FULL, COMMANDS["full_46"]), command=COMMANDS["full_46"])
    assert 'write stepping = "micro"' in line


def test_a_suspicion_is_dropped_where_the_record_fits_as_declared(monkeypatch):
    """Truth: the record as it was made, of which a spectrum is made to suggest another rate."""
    suspected = Suspicions(readings={"r": Reading(rate=replace(COMMANDS["full_46"].rate, rates=(23.0,)))})
    monkeypatch.setattr("mechid.identification.readings.misreading.suspect", lambda *_: suspected)
    bench = campaign(catalogue_mechanism(), record("r", FULL, COMMANDS["full_46"]))
    assert list(find_misreadings(declared(bench))) == []
