"""Effects compared by what they leave. Truth: a detent of 130 periods that made the records."""

import numpy as np
import pytest

from detent_bench import PERIODS, detent_families, look_without_the_detent
from mechid.identification.computation.journal import Journal
from mechid.identification.identify import make_problem
from mechid.identification.stages.compared_effects import look_at_first_moments, look_at_hum
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import fit_look
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, campaign, measured, record, truth


@pytest.fixture(scope="module")
def families():
    return detent_families()


@pytest.fixture(scope="module")
def plain(families):
    return look_without_the_detent(families)


@pytest.mark.slow
def test_the_first_moments_name_the_detent(families, plain):
    """Truth: its number of periods; the look that is grown comes last."""
    looks = look_at_first_moments(families, plain.q, str, Journal())
    (term,) = looks[-1].model.effects
    assert families.periods(term) == pytest.approx(PERIODS, abs=1)
    assert looks[-1].explains
    assert looks[-1].criterion == min(look.criterion for look in looks)


def test_hum_explains_the_first_moments_with_its_own_grid_alone():
    """Truth: hum of 60 Hz, twice the noise, laid over records that the mechanism made."""
    commands = {name: COMMANDS[name] for name in ("full_46", "micro_92")}
    made = []
    for k, (name, command) in enumerate(commands.items()):
        y = measured(truth(), command, np.random.default_rng((7, k)), seconds=0.4)
        y += 2.0 * NOISE_NM * np.sin(2.0 * np.pi * 60.0 * np.arange(y.size) / RATE_HZ + k)
        made.append(record(name, y, command))
    hummed = campaign(truth(), *made)
    families = Families(make_problem(hummed, 1), hummed)
    assert set(families.unseen_grids) == {50.0, 60.0}
    points = [families.plain.start]
    plain = fit_look(families.bare, points[0], Journal())
    right = look_at_hum(families, plain, 60.0, points, str, Journal())
    assert right.explains
    assert right.model.effects == ("mains:60Hz",)
    assert not plain.explains
    wrong = look_at_hum(families, plain, 50.0, points, str, Journal())
    assert wrong is None or not wrong.explains
