"""Values of campaigns brought to one of each unit, trends, groups and changes. Truth: closed forms and seeded draws."""

from datetime import UTC, date, datetime

import numpy as np
import pytest
from scipy.stats import ttest_ind, ttest_rel

from mechid.fleets.changes import changes, mean_change
from mechid.fleets.groups import group_difference
from mechid.fleets.observations import average_by_unit, collect_observations
from mechid.fleets.spread import spread
from mechid.fleets.trends import first_day, remove_trend, trend

SMALL = 1e-6


@pytest.fixture
def seen(member, estimate):
    """Return a function that makes one parameter of rows: value, error, and what a member has beside its label."""

    def make(rows, unit="N m"):
        members = [member(f"c{k}", **options) for k, (_, _, options) in enumerate(rows)]
        return collect_observations("p", members, [estimate(unit, p=(value, error)) for value, error, _ in rows])

    return make


def test_angles_on_both_sides_of_the_turn_are_near(seen):
    o = seen([(179.0, 1.0, {}), (-179.0, 1.0, {}), (178.0, 1.0, {})], unit="deg")
    made = spread(average_by_unit(o))
    assert made.mean == pytest.approx(180.0 - 2.0 / 3.0)
    assert made.spread == pytest.approx(np.sqrt(np.var([-1.0, 1.0, -2.0], ddof=1) - 1.0))


def test_campaigns_of_a_unit_are_averaged_and_their_scatter_counts_in_its_error(seen):
    rows = [
        (1.0, SMALL, {"unit": "A"}),
        (3.0, SMALL, {"unit": "A"}),
        (10.0, SMALL, {"unit": "B"}),
        (14.0, SMALL, {"unit": "B"}),
        (20.0, SMALL, {"unit": "C"}),
    ]
    each = average_by_unit(seen(rows))
    within = np.sqrt((2.0 + 8.0) / 2.0)  # sums of squares of A and B over their degrees of freedom
    assert each.units == ("A", "B", "C")
    assert each.values == pytest.approx([2.0, 12.0, 20.0])
    assert each.repeatability == pytest.approx(within)
    assert each.errors == pytest.approx([within / np.sqrt(2.0), within / np.sqrt(2.0), within])


def test_a_trend_within_units_is_not_misled_by_units_measured_at_other_temperatures(seen):
    """Each unit falls by 0.5 for each kelvin; those measured hotter lie higher, so that a line over all would rise."""
    rows = [
        (10.0 * unit - 0.5 * kelvin, SMALL, {"unit": f"u{unit}", "covariates": {"T": 3.0 * unit + kelvin}})
        for unit in range(4)
        for kelvin in (0.0, 1.0, 2.0)
    ]
    found = trend(seen(rows), "T", None)
    assert found.within
    assert found.slope == pytest.approx(-0.5)
    assert (found.units, found.campaigns, found.dof) == (4, 12, 7)


def test_a_trend_over_units_holds_its_interval(seen):
    rng, hits = np.random.default_rng(9), 0
    for _ in range(200):
        x = rng.uniform(-20.0, 50.0, 8)
        rows = [(5.0 + 0.1 * a + 2.0 * rng.standard_normal(), 0.5, {"covariates": {"T": a}}) for a in x]
        low, high = trend(seen(rows), "T", None).slope95
        hits += low < 0.1 < high
    assert 0.89 < hits / 200 < 0.995


def test_dates_are_counted_in_days_whatever_they_are_written_as(seen):
    days = [date(2026, 3, 1), datetime(2026, 3, 2, 12), datetime(2026, 3, 4, tzinfo=UTC), date(2026, 3, 6)]
    rows = [(2.0 * k, SMALL, {"covariates": {"date": d}}) for k, d in zip((0.0, 1.5, 3.0, 5.0), days, strict=True)]
    o = seen(rows)
    first = first_day(o.members, "date")
    found = trend(o, "date", first)
    assert first == days[0]
    assert found.slope == pytest.approx(2.0)
    assert found.reference == pytest.approx(9.5 / 4.0)
    assert remove_trend(o, found, first).values == pytest.approx(np.full(4, 2.0 * 9.5 / 4.0))


@pytest.mark.parametrize(
    "rows",
    [
        [(1.0, 1.0, {"covariates": {"T": 1.0}}), (2.0, 1.0, {"covariates": {"T": 2.0}})],
        [(float(k), 1.0, {"covariates": {"T": 20.0}}) for k in range(5)],
        [(1.0, 1.0, {}), (2.0, 1.0, {}), (3.0, 1.0, {})],
    ],
    ids=["two campaigns", "one temperature", "no temperature"],
)
def test_where_a_line_cannot_be_told_there_is_none(seen, rows):
    assert trend(seen(rows), "T", None) is None


def test_two_groups_are_compared_as_by_the_t_test(seen, member):
    a, b = [1.0, 2.0, 4.0], [6.0, 7.0, 5.0, 9.0]
    o = seen([(v, SMALL, {"group": g}) for g, values in (("a", a), ("b", b)) for v in values])
    found = group_difference("p", average_by_unit(o), o.members)
    assert found.p_value == pytest.approx(ttest_ind(a, b).pvalue, rel=1e-6)
    assert [(m.group, m.units) for m in found.means] == [("a", 3), ("b", 4)]
    assert [m.mean for m in found.means] == pytest.approx([np.mean(a), np.mean(b)])


def test_changes_are_differences_within_units_and_their_mean_is_the_paired_t_test(seen):
    before, after = [1.0, 5.0, 9.0, 2.0], [1.5, 5.9, 9.2, 2.8]
    rows = [
        (v, SMALL, {"unit": f"u{k}", "state": s})
        for s, values in (("b", before), ("a", after))
        for k, v in enumerate(values)
    ]
    each = changes(seen([*rows, (7.0, SMALL, {"unit": "alone", "state": "b"})]), ("b", "a"))
    assert [c.difference for c in each] == pytest.approx(np.subtract(after, before))
    assert mean_change(each).p_value == pytest.approx(ttest_rel(after, before).pvalue, rel=1e-6)
    assert mean_change(each[:1]) is None


def test_an_angle_changes_the_short_way_round(seen):
    rows = [(179.0, 0.3, {"unit": "u", "state": "b"}), (-179.0, 0.4, {"unit": "u", "state": "a"})]
    (change,) = changes(seen(rows, unit="deg"), ("b", "a"))
    assert change.difference == pytest.approx(2.0)
    assert change.error == pytest.approx(0.5)
    assert change.p_value == pytest.approx(6.334e-5, rel=1e-3)  # 4 sigmas, two-sided
