"""Grades and their reasons. Truth: the order of the grades, and the dictionary that estimate.json holds."""

import json

from mechid.identification.result.grade import (
    CAUSE_WORDS,
    GRADE_WORDS,
    NOTHING_EXPLAINS,
    Cause,
    Consistency,
    FitOutcome,
    Grade,
    Reason,
    Scatter,
    grade_of,
    grade_words,
)


def test_the_worst_reason_decides():
    assert grade_of(tuple(Reason(cause=c, text="") for c in (Cause.THRESHOLD, Cause.LEFT_OUT))) is Grade.C
    assert [g for g in Grade if g.good] == [Grade.A, Grade.B]


def test_a_reason_comes_back_from_json():
    reason = Reason(cause=Cause.THRESHOLD, text="x", record="sweep", instant_s=0.3, widened_most=2.0)
    assert Reason.from_dict(json.loads(json.dumps(reason.to_dict()))) == reason


def test_every_grade_and_cause_has_words():
    assert set(GRADE_WORDS) == set(Grade)
    assert set(CAUSE_WORDS) == set(Cause)
    assert len(set(CAUSE_WORDS.values())) == len(Cause)


def test_the_agreement_of_parts_comes_back_from_json():
    found = Consistency(phase=Scatter(ratio=1.1, z=3.9, clusters=32), parameter="gear.damping")
    assert Consistency.from_dict(json.loads(json.dumps(found.to_dict()))) == found


def test_stretches_of_time_count_where_nothing_else_was_compared():
    """Truth: the limit of four standard deviations of chance; a hum scatters stretches without moving a value."""
    apart, alike = Scatter(ratio=3.0, z=4.1, clusters=8), Scatter(ratio=1.0, z=0.2, clusters=8)
    assert not Consistency(time=apart).agrees
    assert Consistency(time=apart, record=alike).agrees
    assert not Consistency(time=alike, phase=apart).agrees


def test_a_search_that_stopped_short_still_has_an_optimum():
    short = {one for one in FitOutcome if one.has_stopped_short}
    assert short == {FitOutcome.CLIFF, FitOutcome.NOT_CONVERGED}
    assert all(one.has_optimum for one in short)
    assert not any(one.has_optimum for one in (FitOutcome.FAILED, FitOutcome.INTERRUPTED, FitOutcome.HORIZON))


def test_the_first_line_says_where_nothing_explains_the_records():
    """Truth: a grade C has other causes than a search that came to no end; a better grade has come to one."""
    assert grade_words(Grade.C, FitOutcome.HORIZON) == NOTHING_EXPLAINS
    assert NOTHING_EXPLAINS.startswith("Grade C: ")
    assert grade_words(Grade.C, FitOutcome.CONVERGED) == GRADE_WORDS[Grade.C]
    assert grade_words(Grade.FAILED, FitOutcome.FAILED) == GRADE_WORDS[Grade.FAILED]
