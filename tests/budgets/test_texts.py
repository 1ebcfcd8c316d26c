"""The texts of a budget's numbers. Truth: the numbers."""

import pytest

from mechid.budgets.texts import add_texts


def test_one_number_decides_what_is_met(data):
    """Truth: the rule. The lower 95 % limit of the margin of the coupling that decides, and no other number."""
    for row in data["requirements"]:
        margin = row["two_way"] if row["decided"]["coupling"] == "two-way" else row
        assert row["decided"]["margin95"] == pytest.approx(margin["margin95"])
        assert row["met"] == row["decided"]["met"] == (row["decided"]["margin95"][0] >= 0.0)
    shown = [row["text"]["deciding"] for row in add_texts(data)["requirements"]]
    assert shown == [f"{100.0 * row['decided']['margin95'][0]:.1f}" for row in data["requirements"]]
