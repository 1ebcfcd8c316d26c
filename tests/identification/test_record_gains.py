"""Gains of single records of a mechanism whose file has no transducer, from the end of a search to all that uses a fit.

Truth: the gains by which an independent simulator multiplied the records.
"""

import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest

import mechid
from disturbed_bench import written
from mechid.analysis import validate
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.campaign import load_campaign
from mechid.errors import InputFileError
from mechid.identification.conclude import conclude
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import FoundDisturbance
from mechid.identification.effects.effect import AddedTerms, lay_out
from mechid.identification.identify import make_problem
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import FitOutcome, Grade
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results

GAINS = {"full": 1.02, "half": 0.985, "micro": 1.01}
TABLE = "transducer"


def own(record):
    return f"record.{record}.{TABLE}.gain"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a campaign, its fit with gains, and the folder of what identify leaves; nothing is searched."""
    folder = tmp_path_factory.mktemp("gains")
    campaign, truth = written(folder, {}, sizes={name: {"gain_common": gain - 1.0} for name, gain in GAINS.items()})
    plain, added = make_problem(campaign, 1), lay_out(AddedTerms(campaign.mechanism), (), (TABLE,))
    (gains,) = (one for one in possible_disturbances(added.problem(plain), campaign) if one.name == "record.gain")
    problem = added.problem(plain, [gains])
    solution = solve(problem, problem.coordinates.point(truth), problem.whole_windows())
    state = SearchState(
        problem,
        solution.q,
        problem.whole_windows(),
        outcome=FitOutcome.CONVERGED,
        solution=solution,
        searched=True,
        found=(FoundDisturbance(gains, 1000.0, 1.0),),
        added=added,
    )
    fit = conclude(campaign, state, seed=1, seconds=1.0)
    validation = validate(campaign, fit)
    write_results(fit, report_data(fit, validation=validation), folder / "out", validation=validation)
    return SimpleNamespace(campaign=campaign, truth=truth, fit=fit, folder=folder, out=folder / "out")


def test_gains_are_the_truth_and_the_mechanism_is_none_the_worse(made):
    fit = made.fit
    for name, value in {**{own(record): gain for record, gain in GAINS.items()}, **made.truth}.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 4.0 * p.std_error, name
    assert fit.grade is Grade.A
    (entry,) = fit.missing
    assert (entry.name, entry.dof) == ("record.gain", 3), "records tell their mean: a known inertia shows it"
    assert not any("mean counts" in line for line in fit.warnings)
    assert fit.as_written is None, "no effect of the mechanism was added"


def test_the_files_left_behind_declare_the_gains(made):
    """Truth: the mechanism file left behind with what missing says at the end of the campaign file."""
    table = tomllib.loads((made.out / "mechanism.toml").read_text(encoding="utf-8"))
    assert table[TABLE] == {"gain": 1.0}
    text = made.campaign.path.read_text(encoding="utf-8") + "\n" + made.fit.missing[0].toml
    path = made.folder / "declared.toml"
    path.write_text(text.replace('"mechanism.toml"', '"out/mechanism.toml"'), encoding="utf-8")
    free = {p.name: p for record in load_campaign(path).records for p in record.parameters if p.is_free}
    assert {name: p.value for name, p in free.items()} == {own(r): made.fit.values[own(r)] for r in GAINS}
    assert f"# The mechanism file needs a table [{TABLE}].\n" in text
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputFileError, match=r"write \[transducer\] in its file"):
        load_campaign(path)


def test_the_fit_is_read_back_with_and_without_its_campaign(made):
    """Truth: the fit itself, and the optimum that it rebuilds."""
    for fit in (read_fit(made.out), read_fit(made.out, made.campaign)):
        assert fit.values == made.fit.values
        assert fit.mechanism.plant.digest == made.fit.mechanism.plant.digest
    fit = mechid.load_fit(made.out, made.campaign.path)
    optimum = fit.optimum
    found = optimum.problem.coordinates.values(optimum.q)
    for record in GAINS:
        assert abs(found[own(record)] - made.fit.values[own(record)]) < made.fit.parameters[own(record)].std_error
    again = validate(made.campaign, fit)
    for record in GAINS:
        assert again[record].channels["torque"].fit_percent == pytest.approx(
            made.fit.records[record].fit_percent, abs=0.01
        )


def test_a_diagnosis_begins_with_the_gains(made):
    """Truth: residuals of noise alone with the gains, and far more without them."""
    plain, whole = initial_models(replace(made.fit, campaign=made.campaign))
    assert whole.disturbances == ("record.gain",)
    assert whole.over_noise == pytest.approx(1.0, abs=0.05)
    assert plain.over_noise > 2.0


def test_report_budget_and_export_use_the_fit(made, tmp_path):
    """Truth: a gain is the bench's, so that the mechanism flies without it."""
    fit = mechid.load_fit(made.out, made.campaign.path)
    written_files = {path.name for path in mechid.report(fit, tmp_path / "report")}
    assert {"report.html", "report.md"} <= written_files
    page = (tmp_path / "report" / "report.md").read_text(encoding="utf-8")
    assert all(own(record) in page for record in GAINS)
    flying = flying_estimate(fit, Flight())
    assert set(flying.names) == set(made.truth)
    assert f"{TABLE}.gain" not in flying.mechanism.parameters
    exported = mechid.export(made.out, to="c", out=tmp_path / "c", campaign=made.campaign.path)
    assert (exported.folder / "mechid_export.json").is_file()


@pytest.mark.slow
def test_a_gain_beyond_the_range_of_its_prior_is_found(tmp_path):
    """Truth: the gains, one of them 18 % off: 3 % is the prior's width, 15 % its range before it becomes wider."""
    gains = {**GAINS, "full": 1.18}
    campaign, truth = written(tmp_path, {}, sizes={name: {"gain_common": gain - 1.0} for name, gain in gains.items()})
    fit = mechid.identify(campaign, workers=1)
    assert fit.grade is Grade.A
    for name, value in (truth | {own(record): gain for record, gain in gains.items()}).items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 3.0 * p.std_error, name
