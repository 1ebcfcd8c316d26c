"""Prediction of an emission by a fit. Truth: the rules of docs/emission.md, and lines that the records hold."""

import json

import pytest

import mechid
from emission_bench import background, record, requirement, samples, write_campaign
from mechid.emissions.predicted import decide, estimate_for
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.fit_file import read_fit
from mechid.specification.verdict import Judged, Verdict, Worst
from paper_estimate import write_estimate_of_paper

WIDE = ((5.0, 1.0), (400.0, 1.0))


def judged(verdict, over=0.5):
    worst = Worst(
        record="r",
        rate=1.0,
        frequency_hz=1.0,
        value=over,
        sigma=0.0,
        limit=1.0,
        lower=0.0,
        upper=2.0,
        background=0.0,
        margin_db=0.0,
    )
    return Judged(verdict=Verdict(verdict), worst=worst)


@pytest.mark.parametrize(
    ("measured", "over", "predicted", "place", "verdict"),
    [
        ("pass", 0.5, "pass", "bench", "pass"),
        ("pass", 0.5, "fail", "bench", "fail"),
        ("pass", 0.5, "not_decidable", "bench", "not_decidable"),
        ("fail", 1.5, "pass", "bench", "fail"),
        ("fail", 1.5, "pass", "flight", "pass"),
        ("not_decidable", 0.5, "pass", "bench", "pass"),
        ("not_shown", 0.9, "pass", "bench", "pass"),
        ("not_shown", 1.1, "pass", "bench", "not_shown"),
        ("not_shown", 1.1, "fail", "bench", "fail"),
    ],
)
def test_records_and_prediction_are_decided_together(measured, over, predicted, place, verdict):
    assert decide(judged(measured, over), judged(predicted), place).verdict == verdict


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    return read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("fit")))


def write_bench(folder, *wanted):
    runs = {"run": samples(1, ((46.0, 0.05),)), "off": samples(2)}
    return write_campaign(folder, runs, record("run", 46.0), background(), *wanted)


@pytest.mark.slow
def test_a_fit_judges_rates_that_were_not_tested(fit, tmp_path):
    """Truth: the paper's microsteps exert 0.063 N m at the resonance of the load, 46.9 steps/s, and 0.004 at 20."""
    tight, loose = ((5.0, 0.05), (400.0, 0.05)), ((5.0, 0.08), (400.0, 0.08))
    ranges = "rates = [[44.0, 48.0]]"
    wanted = [
        requirement("loose", "torque", unit="N*m", mask=loose, more=ranges),
        requirement("tight", "mz", unit="N*m", mask=tight, more=ranges),
        requirement("side", "fx", mask=WIDE),
    ]
    found = mechid.emission(write_bench(tmp_path, *wanted), fit=fit)
    assert [one.verdict for one in found.assessments] == ["pass", "fail", "not_decidable"]
    assert [one.judged.verdict for one in found.assessments] == ["pass", "not_shown", "pass"]
    assert len(found.assessments[0].prediction.at_rates) > 20
    assert not found.passes
    assert any("predicts the torque alone, not fx" in note for note in found.notes)
    found.write(tmp_path / "out")
    data = json.loads((tmp_path / "out" / "emission.json").read_text())
    assert data["prediction"]["values"] == "bench"
    assert data["requirements"][1]["predicted"]["verdict"] == "fail"
    assert data["requirements"][1]["records"]["verdict"] == "not_shown"
    order = next(one for one in data["prediction"]["orders"] if one["order"] == 1.0)
    assert order["measured"][0]["amplitude"] == pytest.approx(0.05, rel=0.02)
    rows = (tmp_path / "out" / "predicted.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(len(one["predicted"]["at_rates"]) for one in data["requirements"])
    assert rows[1].startswith("loose,torque,amplitude,N*m,micro16,pass,")
    names = {path.stem for path in (tmp_path / "out" / "figures").glob("*.svg")}
    assert {"emission_orders_micro16", "emission_requirement_1_over_rate"} <= names
    page = (tmp_path / "out" / "emission.html").read_text()
    assert '<h2 id="prediction"' in page
    assert "predicts the torque alone, not fx" in page


def test_a_flight_needs_a_fit_and_its_table(fit, tmp_path):
    with pytest.raises(UsageError, match="--flight: says at which values a fit predicts"):
        mechid.emission(tmp_path, flight=tmp_path / "budget.toml")
    (tmp_path / "flight.toml").write_text("seed = 1\n")
    with pytest.raises(InputFileError, match=r"flight.toml: no \[flight\] table"):
        estimate_for(fit, tmp_path / "flight.toml")


def test_the_stand_stays_on_the_bench(fit, tmp_path):
    """Truth: the housing belongs to the test stand; a value of the flight replaces that of the bench."""
    (tmp_path / "flight.toml").write_text("[flight]\nload_inertia = 0.0105\n")
    bench, flying = estimate_for(fit, None), estimate_for(fit, tmp_path / "flight.toml")
    assert "housing.gain" in bench.names
    assert not any(name.startswith("housing") for name in flying.mechanism.parameters)
    assert flying.mechanism.value("load.inertia") == 0.0105


def test_a_folder_that_is_not_there_is_said(tmp_path):
    with pytest.raises(InputFileError, match="there is no such folder; give the result folder of mechid identify"):
        estimate_for(tmp_path / "nothing", None)


def test_the_file_of_a_budget_serves_as_specification(tmp_path):
    """Truth: one file for both commands; a requirement on the line of sight is passed over."""
    write_bench(tmp_path, requirement())
    pointing = '[[requirement]]\nname = "p"\nindex = "APE"\nlimit_rad = 1e-6\n'
    text = 'axis = "rz"\n[flight]\n[[mode]]\nname = "scan"\n' + pointing + requirement("lines", mask=WIDE)
    (tmp_path / "budget.toml").write_text(text)
    found = mechid.emission(tmp_path, requirements=tmp_path / "budget.toml")
    assert [one.requirement.name for one in found.assessments] == ["lines"]
