"""Frequency of the mains before any model. Truth: that of the hum laid over synthetic records."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.effects.disturbance import lines_of
from mechid.identification.effects.mains import mains
from mechid.identification.identify import make_problem
from mechid.identification.search.rest import rest_window
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, campaign, measured, record, truth

HUM_HZ, REST_S = 50.06, 0.5


@pytest.fixture(scope="module")
def problem():
    """Return the problem of four records that rest for half a second, hum of twice the noise upon them."""
    records = []
    for number, (name, command) in enumerate(COMMANDS.items()):
        y = measured(truth(), command, np.random.default_rng((9, number)), seconds=REST_S + 0.5, time_offset_s=REST_S)
        y += 2.0 * NOISE_NM * np.sin(2.0 * np.pi * HUM_HZ * np.arange(y.size) / RATE_HZ + number)
        late = {"value": REST_S, "min": REST_S - 0.01, "max": REST_S + 0.01}
        records.append(record(name, y, command, time_offset=late))
    return make_problem(campaign(truth(), *records), 1)


def lines_hz(found):
    return {hz for lines in found.lines_hz.values() for hz in lines}


def test_rests_tell_the_frequency_where_motion_hides_it(problem):
    """Truth: 50.06 Hz, which half a second at twice the noise tells to some hundredths of a hertz."""
    rests = {t.name: rest_window(t) for t in problem.targets}
    found = lines_hz(mains(problem, declared_hz=50.0, rests=rests))
    assert sorted(found) == pytest.approx([HUM_HZ, 2.0 * HUM_HZ, 3.0 * HUM_HZ], abs=0.03)
    hidden = lines_hz(mains(problem, declared_hz=50.0))
    assert abs(min(found) - HUM_HZ) < 0.5 * abs(min(hidden) - HUM_HZ)


def test_every_record_keeps_one_frequency_of_its_own(problem):
    rests = {t.name: rest_window(t) for t in problem.targets}
    found = mains(problem, declared_hz=50.0, rests=rests)
    assert set(found.lines_hz) == {t.name for t in problem.targets}


def test_a_campaign_that_declares_its_mains_reads_them_in_its_rests(problem):
    """Truth: as above; the option alone, as a campaign file writes it."""

    records = []
    for target in problem.targets:
        rest = np.array(target.leading.measured)
        records.append(record(target.name, rest, target.command, time_offset={"value": 0.5, "min": 0.49, "max": 0.51}))
    made = replace(campaign(truth(), *records), options=IdentifyOptions(mains=50.0))
    assert min(lines_of(make_problem(made, 1))) == pytest.approx(HUM_HZ, abs=0.015)
