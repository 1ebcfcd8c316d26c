"""A fit that added a term to its mechanism, from the end of its search to what a report says of it.

Truth: the mechanism that made the record, which has a harmonic of the torque constant that the file lacks.
"""

import json
import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mechid.analysis import validate
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.campaign import load_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.prediction import simulate
from mechid.identification.conclude import conclude
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.effects.effect import AddedTerms, add_terms, lay_out, substitute_law
from mechid.identification.identify import make_problem
from mechid.identification.result.estimate_file import estimate_text
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import Cause, FitOutcome, Grade
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.plant.superset import rivals_of, superset_of
from mechid.reports.document import PRESENTER
from mechid.reports.files import write_report
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results
from printing import printed
from synthetic import TRUTH, bench, displaced, truth

TERM = "stepper.torque_harmonic:3"
WORDS = "3rd harmonic of the torque constant"
ORDER, AMPLITUDE, PHASE = (f"stepper.torque_harmonic.0.{key}" for key in ("order", "amplitude", "phase_deg"))
HARMONIC = {AMPLITUDE: 0.02, PHASE: 40.0}
FREE = ("gear.stiffness", "gear.damping")
RECORD = "full_46"
FILTER = "anti_alias:2"
FITS = ["made", *(pytest.param(one, marks=pytest.mark.slow) for one in ("with_law", "with_both"))]
PATH = ("as written", "effects named by the first moments", "those needed there, grown")


def made_by(**tables):
    """Return the true mechanism with further tables, or further keys of the catalogue's."""
    table = {**CATALOGUE, **{name: {**CATALOGUE.get(name, {}), **own} for name, own in tables.items()}}
    return mechanism_from_table(table, "with more than the file").with_values(TRUTH)


def harmonic(amplitude):
    return {"stepper": {"torque_harmonic": [{"order": 3, "amplitude": amplitude, "phase_deg": HARMONIC[PHASE]}]}}


def concluded(truth_of_record, added_to, start):
    """Return a campaign of 0.3 s and its fit, from the optimum of a problem with added terms; nothing is searched."""
    campaign = bench(displaced(truth(), dict.fromkeys(FREE, 1.001)), truth_of_record, RECORD, seed=11, seconds=0.3)
    added = added_to(campaign.mechanism)
    problem = added.problem(make_problem(campaign, 1))
    begun = problem.coordinates.point({**{n: TRUTH[n] for n in FREE}, **start})
    solution = solve(problem, begun, problem.whole_windows())
    state = SearchState(
        problem,
        solution.q,
        problem.whole_windows(),
        outcome=FitOutcome.CONVERGED,
        solution=solution,
        searched=True,
        added=added,
        path=PATH,
    )
    return campaign, conclude(campaign, state, seed=1, seconds=1.0)


def left(campaign, fit, folder):
    """Write what identify leaves of a fit, and return it with the fit read back from there."""
    validation = validate(campaign, fit)
    data = report_data(fit, validation=validation)
    write_results(fit, data, folder, validation=validation)
    write_report(data, campaign, fit, validation, folder)
    return SimpleNamespace(campaign=campaign, fit=fit, folder=folder, read=read_fit(folder, campaign))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    def only_the_term(mechanism):
        return replace(add_terms(superset_of(mechanism, only=[TERM]), [TERM]), widths={})

    campaign, fit = concluded(made_by(**harmonic(HARMONIC[AMPLITUDE])), only_the_term, HARMONIC)
    return left(campaign, fit, tmp_path_factory.mktemp("fit"))


def filtered(mechanism):
    return substitute_law(mechanism, next(law for law in rivals_of(mechanism) if law.name == FILTER))


@pytest.fixture(scope="module")
def with_law(tmp_path_factory):
    """Return a fit to which a law was added that no null value leads to: a low-pass before the recorder."""
    campaign, fit = concluded(
        made_by(anti_alias={"order": 2, "frequency": 12e3}), filtered, {"anti_alias.frequency": 12e3}
    )
    return left(campaign, fit, tmp_path_factory.mktemp("law"))


@pytest.fixture(scope="module")
def with_both(tmp_path_factory):
    """Return a fit to which a law and a term were added: a low-pass, and a harmonic of the torque constant."""
    campaign, fit = concluded(
        made_by(anti_alias={"order": 2, "frequency": 12e3}, **harmonic(HARMONIC[AMPLITUDE])),
        lambda mechanism: lay_out(filtered(mechanism), [TERM]),
        {"anti_alias.frequency": 12e3, **HARMONIC},
    )
    return left(campaign, fit, tmp_path_factory.mktemp("both"))


def estimate_of(made):
    return json.loads((made.folder / "estimate.json").read_text(encoding="utf-8"))


def rms_of_left_mechanism(made, record=RECORD):
    """Return the RMS of a record less what the mechanism file left behind simulates, offset and drift fitted."""
    own = made.campaign.record(record)
    mechanism = load_mechanism(made.folder / "mechanism.toml")
    run = simulate(replace(made.campaign, mechanism=mechanism), record)
    rest = own.data.channel("torque").data - np.asarray(run.torque)
    line = np.stack([np.ones(rest.size), np.linspace(-1.0, 1.0, rest.size)], axis=1)
    rest = rest - line @ np.linalg.lstsq(line, rest, rcond=None)[0]
    return math.sqrt(float(np.mean(rest**2)))


def test_values_are_the_truth_and_the_term_is_a_parameter(made):
    fit = made.fit
    for name, value in {**{n: TRUTH[n] for n in FREE}, **HARMONIC}.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 4.0 * p.std_error
        assert p.added is (name in HARMONIC)
        assert fit.mechanism.value(name) == p.value
    assert fit.parameters[ORDER].added
    assert {n for n, p in fit.parameters.items() if p.added} == {ORDER, *HARMONIC}
    assert set(fit.correlation_names) == {*FREE, *HARMONIC}
    assert all("added" in p for p in estimate_of(made)["parameters"].values())


def test_the_fit_is_graded_b_because_the_file_lacks_the_term(made):
    fit = made.fit
    assert fit.grade is Grade.B
    (reason,) = [r for r in fit.reasons if r.cause is Cause.INCOMPLETE]
    alone, fitted = fit.as_written.residual_over_noise[RECORD], fit.records[RECORD].residual_over_noise
    assert alone > 3.0
    assert fitted == pytest.approx(1.0, abs=0.1)
    assert f"added: {WORDS} ({TERM}). " in reason.text
    assert (
        f"the residual of record {RECORD} is {alone:.3g} times its noise; with it, {fitted:.3g} times." in reason.text
    )
    assert TERM in reason.next_command
    assert "mechid diagnose" in reason.next_command


def test_missing_has_the_term_as_it_has_disturbances(made):
    (entry,) = estimate_of(made)["missing"]
    assert (entry["name"], entry["words"], entry["block"]) == (TERM, WORDS, "stepper.torque_harmonic")
    assert (entry["dof"], entry["aliases"], entry["records"]) == (2, [], [RECORD])
    assert entry["chi_square"] > 1000.0
    assert entry["share"] == pytest.approx(1.0)
    for name in HARMONIC:
        p = made.fit.parameters[name]
        assert entry["parameters"][name] == {"value": p.value, "std_error": p.std_error, "unit": p.unit}
    (table,) = tomllib.loads(entry["toml"])["stepper"]["torque_harmonic"]
    assert table["order"] == 3
    assert table["amplitude"]["value"] == made.fit.parameters[AMPLITUDE].value


@pytest.mark.parametrize("name", FITS)
def test_report_and_files_are_of_the_mechanism_left_behind(name, request):
    """Truth: a simulation of mechanism.toml as it was left."""
    found = request.getfixturevalue(name)
    rms = rms_of_left_mechanism(found)
    report = json.loads((found.folder / "report.json").read_text(encoding="utf-8"))
    assert {row["name"]: row["residual_rms"] for row in report["records"]}[RECORD] == pytest.approx(rms, rel=1e-6)
    assert found.fit.records[RECORD].residual_rms == pytest.approx(rms, rel=1e-6)
    (row,) = [row for row in report["validation"] if row["name"] == RECORD]
    assert row["residual_rms"] == pytest.approx(rms, rel=1e-4)  # integrated more accurately
    assert "beside" not in estimate_of(found)
    assert estimate_of(found)["as_written"] == found.fit.as_written.to_dict()


@pytest.mark.parametrize("name", FITS)
def test_the_mechanism_comes_back_from_the_file_left_behind(name, request):
    found = request.getfixturevalue(name)
    again = load_mechanism(found.folder / "mechanism.toml")
    assert again.plant.digest == found.fit.mechanism.plant.digest
    assert {n: again.value(n) for n in again.parameters} == {
        n: found.fit.mechanism.value(n) for n in found.fit.mechanism.parameters
    }
    assert [p.name for p in again.free] == [p.name for p in found.fit.mechanism.free]
    for fit in (found.read, read_fit(found.folder)):
        assert fit.mechanism.plant.digest == found.fit.mechanism.plant.digest
        assert fit.as_written == found.fit.as_written
        assert fit.missing == found.fit.missing
        assert replace(fit, provenance={}).parameters == found.fit.parameters
    assert estimate_text(found.read) == estimate_text(read_fit(found.folder))


def test_the_file_left_behind_marks_what_was_added(made, with_law):
    text = (made.folder / "mechanism.toml").read_text(encoding="utf-8")
    head, body = text.split("assembly = ")
    assert TERM in head
    chi_square = made.fit.missing[0].chi_square
    note = f"# added by mechid: {WORDS}; the records need it (chi-square {chi_square:.4g} for 2)\n"
    assert f"{note}[[stepper.torque_harmonic]]" in body
    assert body.count("added by mechid") == 1
    text = (with_law.folder / "mechanism.toml").read_text(encoding="utf-8")
    assert text.count("# added by mechid: ") == 1
    assert ")\n[anti_alias]" in text[text.index("# added by mechid") :]


def test_a_budget_flies_the_term_and_leaves_the_filter_on_the_bench(made, with_law):
    flying = flying_estimate(read_fit(made.folder), Flight())
    assert flying.mechanism.value(AMPLITUDE) == made.fit.mechanism.value(AMPLITUDE)
    assert set(flying.names) == {*FREE, *HARMONIC}
    flying = flying_estimate(read_fit(with_law.folder), Flight())
    assert "[anti_alias]" in flying.left
    assert set(flying.names) == set(FREE)


@pytest.mark.parametrize("width", [80, 160])
def test_the_terminal_marks_the_term_and_says_how_the_file_does(made, width):
    text = printed(PRESENTER.print, report_data(made.read), width)
    lines = text.splitlines()
    assert any("amplitude" in line and line.rstrip().endswith("free, added") for line in lines)
    ratio = made.fit.as_written.residual_over_noise[RECORD]
    follows = "follows the records too" if made.fit.as_written.follows else "does not follow all records"
    said = f"The mechanism file as written, at the same values, {follows} and leaves {ratio:.3g} to {ratio:.3g}"
    assert said in " ".join(lines)
    assert "To declare it, at the end of mechanism.toml" in lines


def test_page_and_markdown_have_the_term(made):
    page, text = ((made.folder / f"report.{suffix}").read_text(encoding="utf-8") for suffix in ("html", "md"))
    for shown in (page, text):
        assert f"Not declared: {WORDS}" in shown
        assert "The mechanism file as written, at the same values," in shown
        assert "free, added" in shown
    assert "beside the mechanism file" not in page


def test_a_law_is_an_entry_of_missing_too(with_law):
    (entry,) = with_law.fit.missing
    assert (entry.name, entry.block, entry.dof) == ("anti_alias", "anti_alias", 1), "its table holds the order"
    assert entry.chi_square > 100.0
    assert with_law.fit.parameters["anti_alias.frequency"].value == pytest.approx(12e3, rel=0.02)
    assert with_law.fit.grade is Grade.B


@pytest.mark.slow
def test_a_law_and_a_term_are_both_entries_of_missing(with_both):
    """Truth: the mechanism that made the record has both; each fall by a fit without it."""
    fit = with_both.fit
    assert {one.name: (one.block, one.dof) for one in fit.missing} == {
        TERM: ("stepper.torque_harmonic", 2),
        "anti_alias": ("anti_alias", 1),
    }
    for name, value in {**HARMONIC, "anti_alias.frequency": 12e3}.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 4.0 * p.std_error
        assert p.added
    falls = {one.name: one.chi_square for one in fit.missing}
    assert all(fall > 100.0 for fall in falls.values())
    assert sum(one.share for one in fit.missing) == pytest.approx(1.0, abs=0.2)
    assert fit.grade is Grade.B
    (reason,) = [r for r in fit.reasons if r.cause is Cause.INCOMPLETE]
    assert f"lacks effects that the records need; added: {fit.missing[0].words} ({fit.missing[0].name})" in reason.text
    tables = [tomllib.loads(one.toml) for one in sorted(fit.missing, key=lambda one: one.name)]
    assert tables[0].keys() == {"anti_alias"}
    assert tables[1].keys() == {"stepper"}


@pytest.mark.slow
def test_a_law_explains_what_a_fit_without_it_leaves(with_both):
    """Truth: a fit of the same record by the mechanism with the term alone, at the level of the full fit's residual."""
    fit = with_both.fit
    superset = superset_of(with_both.campaign.mechanism, only=[TERM])
    alone = replace(add_terms(superset, [TERM]), widths={}).problem(make_problem(with_both.campaign, 1))
    q = solve(alone, alone.coordinates.point(fit.values), alone.whole_windows()).q
    (target,) = alone.targets
    left = alone.total_norm(q, alone.whole_windows()) * target.leading.sigma
    full = fit.records[RECORD].residual_rms
    expected = (left / full) ** 2 - fit.records[RECORD].samples
    (entry,) = [one for one in fit.missing if one.name == "anti_alias"]
    assert entry.chi_square == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_the_file_left_behind_declares_a_law_and_a_term(with_both):
    text = (with_both.folder / "mechanism.toml").read_text(encoding="utf-8")
    body = text.split("assembly = ")[1]
    assert body.count("added by mechid") == 2
    for one in with_both.fit.missing:
        note = f"# added by mechid: {one.words}; the records need it (chi-square {one.chi_square:.4g} for {one.dof})\n"
        assert body.count(note) == 1
    table = tomllib.loads(text)
    assert table["anti_alias"]["order"] == 2
    assert [one["order"] for one in table["stepper"]["torque_harmonic"]] == [3]
    flying = flying_estimate(read_fit(with_both.folder), Flight())
    assert set(flying.names) == {*FREE, *HARMONIC}


@pytest.mark.slow
def test_a_term_that_no_list_has_is_said_in_words_and_diagnosed(tmp_path):
    """Truth: a detent of 130 periods that made the record, which is none of the library's lists."""
    name, amplitude = "stepper.detent:2.77deg", 0.004
    detent = {"period_deg": 360.0 / 130, "amplitude": amplitude, "phase_deg": 30.0}
    campaign, fit = concluded(
        made_by(stepper={"detent": [*CATALOGUE["stepper"]["detent"], detent]}),
        lambda mechanism: lay_out(AddedTerms(mechanism), [name]),
        {"stepper.detent.2.amplitude": amplitude, "stepper.detent.2.phase_deg": 30.0},
    )
    (entry,) = fit.missing
    assert (entry.name, entry.dof) == (name, 2)
    assert entry.words == "detent torque with a period of 2.77 deg of the rotor"
    found = left(campaign, fit, tmp_path)
    assert f"# added by mechid: {entry.words}; " in (tmp_path / "mechanism.toml").read_text(encoding="utf-8")
    _, whole = initial_models(replace(found.read, campaign=campaign))
    assert whole.terms == (name,)
    assert whole.over_noise == pytest.approx(1.0, abs=0.05)
    assert (
        flying_estimate(read_fit(tmp_path), Flight()).mechanism.value("stepper.detent.2.amplitude")
        == (fit.values["stepper.detent.2.amplitude"])
    )


def test_how_the_search_arrived_is_kept_and_shown(made):
    """Truth: the names given to the state of the search."""
    assert made.fit.path == made.read.path == PATH
    assert estimate_of(made)["outcome"]["path"] == list(PATH)
    said = f"How the search arrived: {', then '.join(PATH)}."
    shown = " ".join(printed(PRESENTER.print, report_data(made.read), 80).split())
    assert said in shown
    for suffix in ("html", "md"):
        assert said in (made.folder / f"report.{suffix}").read_text(encoding="utf-8")
    without = replace(made.fit, path=())
    assert "How the search arrived" not in printed(PRESENTER.print, report_data(without), 80)


def test_a_fit_without_added_terms_has_nothing_as_written():
    """Truth: a record of the mechanism of the file."""
    campaign = bench(displaced(truth(), dict.fromkeys(FREE, 1.001)), truth(), RECORD, seed=11, seconds=0.3)
    problem = make_problem(campaign, 1)
    solution = solve(problem, problem.start, problem.whole_windows())
    state = SearchState(
        problem, solution.q, problem.whole_windows(), outcome=FitOutcome.CONVERGED, solution=solution, searched=True
    )
    fit = conclude(campaign, state, seed=1, seconds=1.0)
    assert fit.grade is Grade.A
    assert (fit.as_written, fit.missing) == (None, ())
    content = fit.to_dict()
    assert content["as_written"] is None
    assert not any(p["added"] for p in content["parameters"].values())
    own = content["records"][RECORD]
    assert own["followed_percent"] == 100.0
    assert own["residual_over_noise"] == own["residual_rms"] / own["noise_known"]


TERMS = (
    "stepper.microstep_table",
    "stepper.torque_harmonic:5",
    "stepper.imbalance",
    "stepper.phase_offset",
    "stepper.saliency",
    "supply.sag",
    "stepper.detent:7.2deg",
    "stepper.detent:1.03deg",
    "friction.directional",
    "friction.position:1",
    "friction.position:output:1",
    "gear.kinematic_error:1",
    "gear.kinematic_error:4",
)
LAWS = (
    "friction.stribeck",
    "friction.load_dependent",
    "gear.backlash",
    "output_friction",
    "housing.second_mode",
    "charge_amplifier",
    "anti_alias:4",
)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TERMS, *LAWS])
def test_every_term_and_law_that_a_fit_may_add_is_in_all_that_it_leaves(name, tmp_path):
    """Truth: a record of the mechanism with the effect, and a simulation of the mechanism file that is left."""

    def added(mechanism):
        if name in LAWS:
            return substitute_law(mechanism, next(law for law in rivals_of(mechanism) if law.name == name))
        return replace(add_terms(superset_of(mechanism, only=[name]), [name]), widths={})

    own = added(truth())
    widths = superset_of(truth(), only=[name]).widths if name in TERMS else {}
    size = {n: 0.5 * width for n, width in widths.items()}
    start = {n: size.get(n, own.mechanism.value(n)) for n in own.new}
    found = left(*concluded(own.mechanism.with_values(size), added, start), tmp_path)
    rms = rms_of_left_mechanism(found)
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert report["records"][0]["residual_rms"] == pytest.approx(rms, rel=1e-4)  # in fewer steps of integration
    assert report["validation"][0]["residual_rms"] == pytest.approx(rms, rel=1e-6)
    assert rms < 1.1 * found.fit.records[RECORD].noise_sigma
    for again in (read_fit(tmp_path), found.read):
        assert again.mechanism.plant.digest == found.fit.mechanism.plant.digest
        assert again.values == found.fit.values
    (entry,) = found.fit.missing
    assert entry.name == (name.partition(":")[0] if name in LAWS else name)
    assert set(entry.parameters) == set(own.new)
    tomllib.loads(entry.toml)
    text = (tmp_path / "mechanism.toml").read_text(encoding="utf-8")
    assert f"added by mechid: {entry.words}; the records need it" in text
    flying = flying_estimate(read_fit(tmp_path), Flight())
    assert all(n in flying.mechanism.parameters for n in own.new) or any("[" in what for what in flying.left)
