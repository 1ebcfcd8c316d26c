"""A fit with terms beside its mechanism, from the end of its search to what a report says of it.

Truth: the mechanism that made the record, which has a harmonic of the torque constant that the file lacks.
"""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from mechid.analysis import validate
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import read_flying
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.as_written import incomplete
from mechid.identification.conclude import conclude
from mechid.identification.effects.effect import terms_beside
from mechid.identification.identify import make_problem
from mechid.identification.result.estimate_file import estimate_text, json_text, write_estimate
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import Cause, Grade
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.plant.superset import superset_of
from mechid.reports import print_report, report_data
from mechid.reports.fit.files import write_report
from mechid.reports.fit.lacking import CLEAR_WORDS, NONE_CLEAR
from mechid.reports.fit.results import estimated_text, write_results
from printing import printed
from synthetic import TRUTH, bench, displaced, truth

TERM, OTHER = "stepper.torque_harmonic:3", "stepper.imbalance"
WORDS = "3rd harmonic of the torque constant"
AMPLITUDE, PHASE = "stepper.torque_harmonic.0.amplitude", "stepper.torque_harmonic.0.phase_deg"
HARMONIC = {AMPLITUDE: 0.02, PHASE: 40.0}
FREE = ("gear.stiffness", "gear.damping")


def concluded(harmonic):
    """Return a campaign of 0.3 s and its fit, from the optimum of a problem with two terms; nothing is searched."""
    table = {
        **CATALOGUE,
        "stepper": {
            **CATALOGUE["stepper"],
            "torque_harmonic": [{"order": 3, "amplitude": harmonic, "phase_deg": HARMONIC[PHASE]}],
        },
    }
    made_by = mechanism_from_table(table, "with a harmonic").with_values(TRUTH)
    campaign = bench(displaced(truth(), dict.fromkeys(FREE, 1.001)), made_by, "full_46", seed=11, seconds=0.3)
    beside = terms_beside(superset_of(campaign.mechanism), [TERM, OTHER])
    problem = beside.problem(make_problem(campaign, 1))
    begun = problem.coordinates.point({**{n: TRUTH[n] for n in FREE}, **HARMONIC, AMPLITUDE: harmonic})
    solution = solve(problem, begun, problem.whole())
    state = SearchState(
        problem,
        solution.q,
        problem.whole(),
        outcome=FitOutcome.CONVERGED,
        solution=solution,
        searched=True,
        beside=beside,
    )
    return campaign, conclude(campaign, state, seed=1, seconds=1.0)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return the campaign, its fit as concluded and as read from its file."""
    campaign, fit = concluded(HARMONIC[AMPLITUDE])
    path = tmp_path_factory.mktemp("fit") / "estimate.json"
    write_estimate(fit, path)
    return SimpleNamespace(campaign=campaign, fit=fit, path=path, read=read_fit(path, campaign))


def test_the_values_are_the_truth_and_the_term_is_named(made):
    fit = made.fit
    assert set(fit.parameters) == set(made.campaign.mechanism.parameters), "terms are no parameters of the mechanism"
    for name in FREE:
        p = fit.parameters[name]
        assert abs(p.value - TRUTH[name]) < 4.0 * p.std_error
        assert fit.mechanism.value(name) == p.value
    assert set(fit.beside.names) == {TERM, OTHER}
    assert fit.beside.clear == (TERM,)
    for name, value in HARMONIC.items():
        p = fit.beside.parameters[name]
        assert p.term == TERM
        assert abs(p.value - value) < 4.0 * p.std_error


def test_the_grade_says_what_is_left_with_and_without_the_terms(made):
    """Truth: with them the noise, without them much more than that, by this record's own residual."""
    fit = made.fit
    assert fit.grade is Grade.B
    reason = next(r for r in fit.reasons if r.cause is Cause.INCOMPLETE)
    left = fit.records["full_46"].residual_rms / fit.records["full_46"].noise_sigma
    assert left > 3.0
    assert f"the clearest: {WORDS} ({TERM}). " in reason.text
    assert f"leaves {left:.3g} times the noise of record full_46" in reason.text
    with_them = float(reason.text.removesuffix(" times.").rpartition(" ")[2])
    assert with_them == pytest.approx(1.0, abs=0.1)
    assert TERM in reason.next_command


def test_the_share_that_is_followed_is_of_the_record_that_is_named(made):
    """Truth: two records made by hand, of which the one with the smaller residual is followed less."""
    own = made.fit.records["full_46"]

    def record(name, ratio, followed):
        channel = replace(own.channels["torque"], followed_percent=followed)
        return replace(own, name=name, residual_rms=ratio * own.noise_known, channels={"torque": channel})

    records = {"loud": record("loud", 9.0, 100.0), "lost": record("lost", 2.0, 40.0)}
    fit, with_terms = replace(made.fit, records=records), replace(made.fit, records=dict.fromkeys(records, own))
    of_both = incomplete(fit, with_terms, list(records), "campaign.toml")
    assert of_both.record == "loud"
    assert "leaves 9 times the noise of record loud; with" in of_both.text
    of_one = incomplete(fit, with_terms, ["lost"], "campaign.toml")
    assert "leaves 2 times the noise of record lost (and follows 40 % of it); with" in of_one.text


def test_it_comes_back_from_its_file(made):
    assert estimate_text(made.read) == estimate_text(made.fit)
    assert made.read.beside == made.fit.beside


def test_the_estimated_mechanism_file_says_that_it_lacks_the_term(made):
    text = estimated_text(made.fit, synthetic=True)
    comment = text[: text.index("assembly")]
    assert "INCOMPLETE" in comment
    assert TERM in comment
    assert OTHER not in text


def test_the_mechanism_as_written_flies_and_the_budget_says_what_it_lacks(made, tmp_path):
    """Truth: the file left beside the estimate, which has to have the equations that the estimate names."""
    write_results(made.fit, report_data(made.fit), tmp_path)
    estimate = read_flying(tmp_path / "estimate.json", Flight())
    assert AMPLITUDE not in estimate.mechanism.parameters
    assert set(estimate.names) == set(FREE)
    for name in FREE:
        assert estimate.mechanism.value(name) == made.fit.mechanism.value(name)
    assert f"({WORDS})" in estimate.lacking


def test_the_report_has_the_clear_term_in_its_table_and_the_other_apart(made):
    beside = report_data(made.read)["beside"]
    assert [row["name"] for row in beside["clear_terms"]] == [AMPLITUDE, PHASE]
    assert {row["term"] for row in beside["other_terms"]} == {OTHER}
    assert CLEAR_WORDS in beside["said"]
    row = beside["clear_terms"][0]
    estimate = json.loads(made.path.read_text())["beside"]["parameters"][AMPLITUDE]
    assert (row["value"], row["std_error"], row["meaning"]) == (
        estimate["value"],
        estimate["std_error"],
        "amplitude of the harmonic over the torque constant",
    )
    assert float(row["text"]["value"]) == pytest.approx(row["value"], abs=row["std_error"])
    json.loads(json_text(report_data(made.read)))


@pytest.mark.parametrize("width", [80, 160])
def test_the_terminal_shows_it_whole(made, width):
    data = report_data(made.read)
    text = printed(print_report, data, width)
    lines = text.splitlines()
    at = lines.index("Terms beside the mechanism file")
    assert lines[at + 1] == data["beside"]["said"][0]
    shown = " ".join(lines[at : lines.index("", at + 8)])
    for row in data["beside"]["clear_terms"]:
        assert all(word in shown for word in (f"{WORDS} ({TERM})", row["name"], *row["text"].values(), row["meaning"]))
    assert f"{data['beside']['other_words']} {OTHER}" in lines


def test_terms_that_explain_nothing_are_not_called_clear():
    """Truth: a record of a mechanism that has none of them."""
    _, fit = concluded(0.0)
    assert fit.beside.clear == ()
    beside = report_data(fit)["beside"]
    assert beside["clear_terms"] == []
    assert NONE_CLEAR in beside["said"]
    assert "none is clear by itself" in fit.reasons[-1].text


def test_page_and_markdown_have_the_tables(made, tmp_path):
    """Truth: the dict."""
    validation = validate(made.campaign, made.fit)
    data = report_data(made.fit, validation=validation)
    write_report(data, made.campaign, made.fit, validation, tmp_path)
    page, text = ((tmp_path / f"report.{suffix}").read_text(encoding="utf-8") for suffix in ("html", "md"))
    page, text = page[page.index('id="beside"') : page.index('id="parameters"')], text.replace("\\", "")
    beside = data["beside"]
    for row in (*beside["clear_terms"], *beside["other_terms"]):
        term, cells = f"{row['words']} ({row['term']})", (row["name"], *row["text"].values(), row["meaning"])
        assert f"| {term} | {' | '.join(cells)} |" in text
        assert all(f">{cell}</t" in page for cell in (term, *cells))
    for said in (*beside["said"], beside["other_words"]):
        assert said in text
        assert said in page
    summary = json.loads((tmp_path / "report.json").read_text())["summary"]["questions"]
    assert any(line.startswith("Without the terms beside the mechanism file the") for line in summary[0]["answers"])
    assert not [line for line in summary[2]["answers"] if "still contains" in line]
