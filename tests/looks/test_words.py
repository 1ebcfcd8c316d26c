"""What is said of a look. Truth: the sentences, written by hand from the numbers."""

import pytest

from mechid.looks.words import driven_words, mains_word, order_name, resonance_word, with_unit


def suggested(**changes):
    entry = {
        "rates": [41.0],
        "sigma": 0.001,
        "share": 0.9,
        "stepping": "full",
        "microsteps": None,
        "repetition_hz": 41.0,
        "others": [],
    }
    return entry | changes


def declared(*rates, microsteps=1):
    return {"words": f"full steps at {rates[0]:g}", "rates": list(rates), "microsteps": microsteps}


def reading(rate, sigma=0.001, repeats=1.0):
    return {"rate": rate, "sigma": sigma, "repeats": repeats}


@pytest.mark.parametrize(("order", "words"), [(0.25, "order ¼"), (3.0, "order 3"), (1.75, "order 1¾"), (0.0, "")])
def test_an_order_is_written_with_its_quarters(order, words):
    assert order_name(order) == words


def test_a_multiple_of_the_mains_is_named():
    assert mains_word({"mains_hz": 50.0, "mains_multiple": 1}) == "mains 50 Hz"
    assert mains_word({"mains_hz": 60.0, "mains_multiple": 3}) == "mains 60 Hz x 3"
    assert mains_word({"mains_hz": None, "mains_multiple": None}) == ""


def test_a_number_has_its_unit_where_there_is_one():
    assert with_unit(0.3, 2, "N m") == "0.30 N m"
    assert with_unit(0.3, 2, "") == "0.30"


def test_a_resonance_says_what_it_rests_on():
    tracked = {"frequency_hz": 46.9, "spread_hz": 0.31, "orders": [1.0, 2.0], "hump": False}
    expected = "46.9 ± 0.31 Hz: orders 1, 2 of the step rate are largest there, each at its own rate"
    assert resonance_word(tracked) == expected
    hump = {"frequency_hz": 888.0, "spread_hz": 0.0, "orders": [], "hump": True}
    assert resonance_word(hump) == "888 Hz: a hump of the spectrum"


@pytest.mark.parametrize(
    ("driven", "said"),
    [
        ((None, None, None), "The record suggests no step rate"),
        ((None, suggested(), None), "suggests full steps at 41.0000 ± 0.0010 /s"),
        ((declared(41.0), suggested(), reading(41.0005)), "as declared; it repeats itself every full step."),
        ((declared(41.0), suggested(), reading(41.2)), "more than its error: check clock and rate"),
        ((declared(44.0), suggested(), None), "This contradicts the command: its lines do not fit the rate declared."),
        ((declared(0.0, 50.0), suggested(), None), "but a varying rate is declared"),
        ((declared(0.0, 60.0), suggested(rates=[1.0, 30.1]), None), "That is half the rate declared."),
        ((declared(0.0, 60.0), suggested(rates=[1.0, 43.0]), None), "That is not the rate declared"),
    ],
)
def test_how_a_record_seems_driven_stands_beside_how_it_is_declared(driven, said):
    """Truth: the rules by hand; a rate counts as the one declared within its error."""
    lines = driven_words(dict(zip(("declared", "suggested", "reading"), driven, strict=True)))
    assert any(said in line for line in lines), lines


def test_microsteps_that_are_not_those_declared_are_told():
    """Truth: 16 microsteps a full step at 41 full steps/s, where 32 are declared."""
    seen = suggested(stepping="micro", microsteps=16, repetition_hz=656.0)
    lines = driven_words({"declared": declared(41.0, microsteps=32), "suggested": seen, "reading": reading(41.0)})
    assert lines[-1] == "It shows 16 microsteps a full step, not the 32 declared."
