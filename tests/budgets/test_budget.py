"""A whole budget: which margin decides, and at which rates. Truth: the rules, and the two-way responses."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.budget import _with_deciding
from mechid.budgets.margins import margins
from mechid.budgets.standing import nominal_level


def test_rates_are_added_at_crossings(data):
    """Truth: order 1 meets the structure's 47.5 Hz at 47.5 steps/s, which the range of four rates passes over."""
    scan = data["modes"][0]
    assert 47.5 in scan["rates"]
    assert scan["worst_rate"] == 47.5
    assert any(low < 47.5 < high for low, high in scan["avoid"]["stability in an exposure"])


def test_the_two_way_margin_decides_where_it_was_worked_out(data, made):
    """Truth: the joined model leaves nothing out, and the ratio of the nominal unit's levels; else one-way decides."""
    for row in data["requirements"]:
        ratio = row["two_way_rad"] / row["nominal_rad"]
        assert row["decided"]["coupling"] == "two-way"
        assert row["decided"]["margin"] == pytest.approx(1.0 - ratio * row["level_rad"] / row["limit_rad"])
    slew = made.modes[1].standings[0]
    assert margins(slew, None)["two_way"] is None
    assert margins(slew, None)["decided"] == {
        "coupling": "one-way",
        "level_rad": slew.level.value,
        "sigma_rad": slew.level.sigma,
        "sampling_sigma_rad": slew.sampling_rad,
        "residual_rad": slew.residual_rad,
        "margin": pytest.approx(slew.margin),
        "margin95": pytest.approx(list(slew.margin95)),
        "met": slew.margin95[0] >= 0.0,
    }
    by_duty = data["requirements"][-1]
    assert (by_duty["mode"], by_duty["decided"]["coupling"]) == ("all modes, by duty", "two-way")


def test_levels_over_the_rate_and_rates_to_avoid_are_those_of_the_margin_that_decides(data, made):
    """Truth: the rule, and the two-way responses. The curve peaks at the level and the band that decide."""
    scan, over = data["modes"][0], data["modes"][0]["over_rate"]
    assert over["decided"]["coupling"] == "two-way"
    for row in data["requirements"][:2]:
        name, decided = row["requirement"], row["decided"]
        levels = np.array(over["decided"]["levels_rad"][name])
        assert levels.max() == pytest.approx(decided["level_rad"])
        assert scan["rates"][int(levels.argmax())] == decided["at_rate"]
        nominal = [
            nominal_level(made.file.requirements[0], [(1.0, r)], made.file.errors) for r in made.modes[0].two_way
        ]
        if name == made.file.requirements[0].name:
            np.testing.assert_allclose(levels / levels.max(), np.array(nominal) / max(nominal))
        high = np.array(over["decided"]["levels_ci95_rad"][name])[:, 1]
        assert high[int(levels.argmax())] == pytest.approx(row["limit_rad"] * (1.0 - decided["margin95"][0]))
        assert decided["met"] == (not scan["avoid"][name]) == bool(np.all(high <= row["limit_rad"]))


def test_a_requirement_that_only_one_way_exceeds_has_no_rates_to_avoid(made):
    """Truth: the two levels. At a limit between the two-way and the one-way level nothing is to be avoided."""
    mode = made.modes[0]
    s = mode.standings[0]
    two_way = mode.two_way_levels[s.requirement.name][1] / s.nominal_rad * s.level.ci95[1]
    limit = 0.5 * (two_way + s.level.value)
    assert two_way < limit < s.level.value
    other = replace(s, requirement=replace(s.requirement, limit_rad=limit))
    assert _with_deciding(replace(mode, standings=(other,))).avoid[s.requirement.name] == ()
    one_way = replace(mode, standings=(other,), two_way_curves={}, two_way_levels={})
    assert _with_deciding(one_way).avoid[s.requirement.name] != ()
