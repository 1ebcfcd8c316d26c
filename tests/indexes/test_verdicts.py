"""Verdicts on cards. Truth: numbers written by hand, and those that mechid itself made."""

import pytest

from mechid.indexes import verdicts
from mechid.ink.document import BAD, CAUTION, GOOD


def requirement(margin, met):
    return {"requirement": "r", "mode": "m", "axis": "x", "decided": {"margin": margin, "met": met}}


@pytest.mark.parametrize(
    ("rows", "warnings", "headline", "tone"),
    [
        ([(0.2, True), (0.1, True)], [], "2 of 2 requirements met", GOOD),
        ([(0.2, True), (0.1, True)], ["a mode is missing"], "2 of 2 requirements met", CAUTION),
        ([(0.2, True), (0.01, False)], [], "1 of 2 requirements met", CAUTION),
        ([(0.2, True), (-0.5, False)], [], "1 of 2 requirements met", BAD),
        ([], [], "no requirement is given; the disturbance alone is shown", ""),
    ],
)
def test_a_budget_is_as_good_as_its_least_margin(rows, warnings, headline, tone):
    found = verdicts.budget_verdict({"requirements": [requirement(*row) for row in rows], "warnings": warnings})
    assert (found.headline, found.tone) == (headline, tone)


@pytest.mark.parametrize(
    ("grade", "headline", "tone"),
    [("A", "Grade A", GOOD), ("B", "Grade B", GOOD), ("C", "Grade C", CAUTION), ("failed", "Failed", BAD)],
)
def test_a_fit_is_as_good_as_its_grade(grade, headline, tone):
    found = verdicts.fit_verdict({"grade": grade, "grade_reasons": []})
    assert (found.headline, found.tone) == (headline, tone)


def test_a_fleet_names_what_differs_and_who_stands_off():
    parameter = {"name": "gear.stiffness", "differs": True, "outliers": [{"unit": "FM3"}]}
    found = verdicts.fleet_verdict({"campaigns": [1, 2], "failed": [], "parameters": [parameter], "cautions": []})
    assert found.tone == CAUTION
    assert found.lines == ("differ from unit to unit: gear.stiffness", "stand off: FM3")
    assert verdicts.fleet_verdict({"campaigns": [1], "failed": ["a"], "parameters": [], "cautions": []}).tone == BAD


def test_a_campaign_that_is_a_template_says_so():
    records = [{"name": "a", "command": {}}, {"name": "b", "command": {"rate": 1.0}, "use": "validate"}]
    found = verdicts.campaign_verdict({"record": records})
    assert found.headline == "1 record to estimate from, 1 to validate with"
    assert found.tone == CAUTION


def test_a_card_has_few_lines_and_says_how_many_it_leaves_out():
    warnings = [f"warning {k}" for k in range(5)]
    found = verdicts.profile_verdict({"profiles": {"gear.stiffness": {}}, "warnings": warnings})
    assert found.lines == ("warning 0", "warning 1", "warning 2", "and 2 more")
    long = verdicts.profile_verdict({"profiles": {"gear.stiffness": {}}, "warnings": ["a" * 1000]})
    assert len(long.lines[0]) < 250


@pytest.mark.slow
def test_a_budget_of_mechid_is_told(tmp_path_factory):
    """Truth: the budget's own numbers."""
    from small_budget import small_budget

    data = small_budget(tmp_path_factory).to_dict()
    met = sum(one["decided"]["met"] for one in data["requirements"])
    assert verdicts.budget_verdict(data).headline == f"{met} of {len(data['requirements'])} requirements met"
    assert len(data["provenance"]["fit"]["mechanism_sha256"]) == 64


@pytest.mark.parametrize(("bound", "tone"), [(3.0, GOOD), (-0.1, CAUTION)])
def test_a_quiet_drive_is_as_good_as_the_bound_of_its_least_gain(bound, tone):
    gains = [{"gain_db": 30.07, "bound_db": 29.0}, {"gain_db": 12.34, "bound_db": bound}]
    found = verdicts.quiet_verdict({"gains": gains, "table": {"bits": 10}, "warnings": ["no rate is recommended"]})
    assert found.headline == "RMS torque down by 12.3 dB or more at the design rates, with 10 bits"
    assert (found.tone, found.lines) == (tone, ("no rate is recommended",))
