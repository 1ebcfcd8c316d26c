"""Single effects one by one. Truth: a detent of 130 periods that made the records."""

import pytest

from detent_bench import PERIODS, detent_families, look_without_the_detent
from mechid.identification.computation.journal import Journal
from mechid.identification.stages import single_effects
from mechid.identification.stages.first_look import first_windows
from mechid.identification.stages.single_effects import look_at_singles

RIGHT, WRONG = "stepper.detent:2.77deg", "stepper.torque_harmonic:3"


@pytest.fixture(scope="module")
def families():
    return detent_families()


@pytest.fixture(scope="module")
def plain(families):
    return look_without_the_detent(families)


@pytest.mark.slow
def test_single_effects_are_looked_at_until_the_number_of_periods_is_right(families, plain, monkeypatch):
    """Truth: 130 periods. The likeliest are given as the derivatives may have them: 4 % off, and another effect.

    The look with the wrong number does not stay beside the right one: as its twin it would hide that this stands out.
    """
    near = families.with_periods(RIGHT, 125)
    monkeypatch.setattr(single_effects, "rank_effects", lambda *_: [[WRONG], [near]])
    windows, said = first_windows(families.plain), []
    listed, looks = look_at_singles(families, families.bare, plain.q, windows, said.append, Journal())
    assert [look.model.effects for look in listed] == [(WRONG,)]
    assert said[1].startswith(f"{near} beside as written")
    (best,) = looks
    (term,) = best.model.effects
    assert families.periods(term) == pytest.approx(PERIODS, abs=1)
    assert best.explains
    assert said[-1].endswith(f"with {families.periods(term)} periods in a turn")


def test_a_kind_is_looked_at_when_it_is_asked_for(families, plain, monkeypatch):
    """Truth: the detent, here given as if it were listed; what comes behind it is not looked at."""
    asked = []

    def kinds(*_):
        for names in ([RIGHT, WRONG], [families.with_periods(RIGHT, 90)]):
            asked.append(names)
            yield names

    monkeypatch.setattr(single_effects, "rank_effects", kinds)
    looks = look_at_singles(families, families.bare, plain.q, first_windows(families.plain), str, Journal())
    first = next(looks)
    assert [look.model.effects for look in first[:2]] == [(RIGHT,), (WRONG,)]
    assert first[0].explains
    assert len(asked) == 1
    (behind,) = next(looks)
    assert not behind.explains
    assert len(asked) == 2
