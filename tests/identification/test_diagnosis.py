"""A diagnosis names what a mechanism file lacks, proposes a file that has it, and names nothing where nothing is."""

import json
import tomllib
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

import mechid
from mechid.analysis.preference import ComparisonOutcome
from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table, read_mechanism
from mechid.campaign.mechanism_text import mechanism_text
from mechid.command import RateProfile
from mechid.errors import FitError, InputFileError
from mechid.identification.diagnosis import completion, search
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.search import in_doubt, small_in_part, standing_in
from mechid.identification.diagnosis.start import begun
from mechid.identification.diagnosis.stretches import in_stretches
from mechid.identification.disturbance.scores import Score
from mechid.identification.identify import identify
from mechid.identification.result.grade import Grade
from mechid.identification.result.outcome import FitOutcome
from mechid.reports import report_data
from mechid.reports.console import console_on
from mechid.reports.diagnosis.contents import diagnosis_data
from mechid.reports.diagnosis.evidence import evidence_lines
from mechid.reports.diagnosis.files import DATA_NAME, PROPOSED_NAME, write_diagnosis
from mechid.reports.diagnosis.terminal import print_diagnosis
from mechid.signal.strongest import strongest
from synthetic import COMMANDS, RATE_HZ, TRUTH, campaign, measured, record

USES = ("estimate", "estimate", "estimate", "validate")
HARMONIC = {"order": 3, "amplitude": 0.01, "phase_deg": 40.0}


def tables(*harmonics):
    """Return the catalogue's tables with harmonics of the torque constant."""
    return {**CATALOGUE, "stepper": {**CATALOGUE["stepper"], "torque_harmonic": list(harmonics)}}


def made(*harmonics):
    """Return a campaign of short records, the last held out, whose mechanism file has no harmonic of the constant."""
    made_by = mechanism_from_table(tables(*harmonics), "with harmonics").with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n], use=use)
        for k, (n, use) in enumerate(zip(("full_46", "full_23", "micro_46", "micro_92"), USES, strict=True))
    ]
    return campaign(catalogue_mechanism(), *records)


@pytest.fixture(scope="module")
def fitted():
    """Return a campaign that lacks a harmonic, and its fit."""
    bench = made(HARMONIC)
    return bench, mechid.identify(bench, workers=1, near=TRUTH)


@pytest.fixture(scope="module")
def lacking(fitted):
    """Return a campaign that lacks a harmonic, and its diagnosis."""
    bench, fit = fitted
    return bench, diagnose(bench, fit, workers=1)


def test_what_is_missing_is_named_with_its_value(lacking):
    """Truth: the harmonic that made the records."""
    _, found = lacking
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    (one,) = found.missing
    assert one.words == "3rd harmonic of the torque constant"
    assert one.block == "stepper.torque_harmonic"
    own = {name.rpartition(".")[2]: p for name, p in one.parameters.items()}
    for key, value in (("amplitude", 0.01), ("phase_deg", 40.0)):
        assert abs(own[key].value - value) < 4.0 * own[key].std_error
    assert own["amplitude"].std_error < 1e-3
    assert one.share > 0.9
    assert one.p_value < 1e-6
    assert found.unexplained == 0.0
    assert found.over_noise[0] > found.over_noise[1] == pytest.approx(1.0, abs=0.03)


def test_the_proposed_mechanism_reads_back_and_fits_with_grade_a(lacking, tmp_path):
    """Truth: the parameters that made the records, from which a fit with the proposed mechanism differs by chance."""
    bench, found = lacking
    path = tmp_path / "mechanism.toml"
    path.write_text(mechanism_text(found.mechanism))
    proposed = read_mechanism(path)
    fit = identify(replace(bench, mechanism=proposed), workers=1, near={p.name: p.value for p in proposed.free})
    assert fit.grade == "A"
    off = [abs(p.value - TRUTH[n]) / p.std_error for n, p in fit.parameters.items() if p.std_error and n in TRUTH]
    assert len(off) >= 10
    assert np.sqrt(np.mean(np.square(off))) < 2.0


def test_the_files_of_a_diagnosis(lacking, tmp_path, capsys):
    """Truth: the contract of diagnose.json, and TOML's own reader."""
    _, found = lacking
    data = diagnosis_data(found)
    files = write_diagnosis(found, data, tmp_path / "out")
    print_diagnosis(data, console_on(), files)
    printed = capsys.readouterr().out
    content = json.loads((tmp_path / "out" / DATA_NAME).read_text())
    assert content["format"] == "mechid-diagnosis/1"
    (one,) = content["missing"]
    assert set(one) == {
        "name",
        "words",
        "block",
        "parameters",
        "chi_square",
        "dof",
        "share",
        "p_value",
        "aliases",
        "records",
        "toml",
        "frequencies_hz",
    }
    assert set(one["frequencies_hz"]) == set(one["records"])
    assert {"share", "words"} == set(content["unexplained"])
    appended = tomllib.loads(mechanism_text(catalogue_mechanism()) + one["toml"])
    assert appended["stepper"]["torque_harmonic"][0]["amplitude"]["value"] == pytest.approx(0.01, rel=0.1)
    assert (tmp_path / "out" / PROPOSED_NAME).is_file()
    folder = tmp_path / "out"
    figures = {path.name for path in (folder / "figures").glob("*.svg")}
    drawn = {"diagnosis_stretch.svg", *(f"diagnosis_{name}_spectrum.svg" for name in one["records"])}
    assert figures == drawn
    page = (folder / "diagnose.html").read_text()
    assert page.count("<svg") == len(figures)
    assert all(f"figures/{name}" in (folder / "diagnose.md").read_text() for name in figures)
    for text in (printed, page, (folder / "diagnose.md").read_text()):
        assert "stepper.torque_harmonic:3 added" in text.replace("\\", "")  # of Markdown
    for text in (printed, *((tmp_path / "out" / name).read_text() for name in ("diagnose.md", "diagnose.html"))):
        assert "3rd harmonic of the torque constant" in text


def test_where_an_effect_acts(lacking):
    """Truth: at a constant rate of full steps all repeats with the electrical period, four of them."""
    for name in ("full_46", "full_23"):
        makers = [mechanism_from_table(table, "made").with_values(TRUTH) for table in (tables(HARMONIC), tables())]
        with_it, without = (measured(m, COMMANDS[name], np.random.default_rng(1), seconds=1.0) for m in makers)
        share = strongest(with_it - without, RATE_HZ)  # of the same noise
        fundamental_hz, bin_hz = COMMANDS[name].rate.rates[0] / 4.0, RATE_HZ / with_it.size
        assert share.in_lines
        assert 1 <= len(share.frequencies_hz) <= 3
        off = [hz - fundamental_hz * round(hz / fundamental_hz) for hz in share.frequencies_hz]
        assert max(map(abs, off)) < 0.5 * bin_hz
    acts = lacking[1].pictures.acts["stepper.torque_harmonic:3"]
    assert all(1 <= len(one.frequencies_hz) <= 3 for one in acts.values())


def test_what_is_drawn_of_what_is_left(lacking):
    """Truth: the noise that was added to the records, which is all that the model with the effect leaves."""
    bench, found = lacking
    assert {one.record for one in found.pictures.spectra} == {r.name for r in bench.estimated}
    for one in found.pictures.spectra:
        assert np.sqrt(np.mean(one.after**2)) == pytest.approx(one.noise, rel=0.15)
        share = one.shares["stepper.torque_harmonic:3"]
        peak = int(np.argmax(share))
        before, without, after = (np.trapezoid(y**2, one.frequency_hz) for y in (one.before, share, one.after))
        assert before == pytest.approx(without + after, rel=0.02)  # at right angles, both models at their optimum
        assert one.before[peak] > 1.4 * one.after[peak]
    stretch = found.pictures.stretch
    assert stretch.record == found.pictures.spectra[0].record
    assert 0.05 <= stretch.measured.size / stretch.sample_rate_hz <= 0.3
    left = [float(np.std(stretch.measured - modelled)) for modelled in (stretch.before, stretch.after)]
    sigma = found.pictures.spectra[0].noise / np.sqrt(2.0 / stretch.sample_rate_hz)
    assert left[0] > left[1]
    assert left[1] == pytest.approx(sigma, rel=0.15)


def test_the_criterion_of_steps_can_be_compared(lacking):
    """Truth: a criterion falls by the chi-square less ln N for each parameter, N at most the samples."""
    bench, found = lacking
    (step,), (one,) = found.steps, found.missing
    assert step.free - found.as_written.free == one.dof
    samples = sum(r.data.samples for r in bench.estimated)
    fall = found.as_written.bic - step.bic
    assert one.chi_square - one.dof * np.log(samples) < fall < one.chi_square
    assert (found.as_written.over_noise, step.over_noise) == found.over_noise


def test_a_fit_says_in_short_what_its_model_is_missing(fitted):
    """Truth: the harmonic that made the records; a complete model is asked nothing."""
    _, fit = fitted
    assert fit.grade == "B"
    assert fit.suggested[0].name == "stepper.torque_harmonic:3"
    said = report_data(fit, {}, synthetic=True)["lacking"]
    assert "3rd harmonic of the torque constant (stepper.torque_harmonic:3)".lower() in said[0].lower()
    assert "mechid diagnose" in said[-1]
    complete = mechid.identify(made(), workers=1, near=TRUTH)
    assert complete.suggested == ()
    assert report_data(complete, {}, synthetic=True)["lacking"] == []


def test_a_record_that_was_held_out_is_predicted_better(lacking):
    """Truth: the record has the harmonic, and its noise is all that the model with it leaves."""
    _, found = lacking
    (one,) = found.held_out
    assert one.record == "micro_92"
    assert one.before > one.after == pytest.approx(1.0, abs=0.05)
    said = evidence_lines(found)
    assert said[0].startswith("The Bayesian criterion prefers the mechanism with these effects decisively")
    assert said[-1] in (ComparisonOutcome.AGREED.value, ComparisonOutcome.UNDECIDED_BY_PREDICTION.value)


def test_only_what_the_campaign_names_is_looked_for(fitted):
    """Truth: a kind stands for all of its periods; what is not named is not fitted."""
    bench, fit = fitted
    found = diagnose(replace(bench, considered=("stepper.torque_harmonic",)), fit, workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    found = diagnose(replace(bench, considered=("clock",)), fit, workers=1)
    assert found.missing == ()
    with pytest.raises(
        InputFileError, match=r'consider\[1\], or --consider: found "stepper.torque_harmonics".*did you mean'
    ):
        diagnose(replace(bench, considered=("clock", "stepper.torque_harmonics")), fit, workers=1)


def test_a_high_pass_that_hides_in_the_noise_is_found():
    """Truth: the time constant of the charge amplifier that the records went through."""
    table = {**CATALOGUE, "charge_amplifier": {"time_constant": 1.0}}
    made_by = mechanism_from_table(table, "with a charge amplifier").with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]
    bench = replace(campaign(catalogue_mechanism(), *records), considered=("charge_amplifier", "clock"))
    found = diagnose(bench, identify(bench, workers=1, near=TRUTH), workers=1)
    assert [one.name for one in found.missing] == ["charge_amplifier"]
    own = found.missing[0].parameters["charge_amplifier.time_constant"]
    assert abs(own.value - 1.0) < 4.0 * own.std_error < 0.5


def test_a_residual_that_nothing_explains_is_said_to_go_with_time():
    """Truth: the sine of 77 Hz that was added to a record whose rate varies; no grid has it, and no effect is asked."""
    command = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 10.0), (1.0, 60.0)]))
    made_by = catalogue_mechanism().with_values(TRUTH)
    torque = measured(made_by, command, np.random.default_rng(9), seconds=1.0)
    torque += 0.02 * np.sin(2.0 * np.pi * 77.0 * np.arange(torque.size) / RATE_HZ)
    bench = replace(campaign(made_by, record("sweep", torque, command)), considered=("clock",))
    near = {p.name: p.value for p in made_by.free}
    found = diagnose(bench, identify(bench, workers=1, near=near), workers=1)
    assert found.missing == ()
    (one,) = found.locked
    assert one.frequencies_hz[0] == pytest.approx(77.0, abs=0.5)
    assert one.share > 0.5
    assert "Nothing in the library explains what is left" in found.words
    assert "77 Hz, whatever the rate" in found.words


@pytest.mark.slow
def test_a_detent_that_no_list_has_is_named_with_its_period():
    """Truth: the detent of 137 periods in a turn, 4 mN m and 30 deg, that made the records; a sweep of 8 s shows it."""
    third = {"period_deg": 360.0 / 137.0, "amplitude": 0.004, "phase_deg": 30.0}
    stepper = {**CATALOGUE["stepper"], "detent": [*CATALOGUE["stepper"]["detent"], third]}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "with a third detent").with_values(TRUTH)
    rising = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 0.0), (8.0, 110.0)]))
    commands = {"full_46": (COMMANDS["full_46"], 1.0), "micro_46": (COMMANDS["micro_46"], 1.0), "sweep": (rising, 8.0)}
    records = [
        record(n, measured(made_by, command, np.random.default_rng((5, k)), seconds=seconds), command)
        for k, (n, (command, seconds)) in enumerate(commands.items())
    ]
    bench = campaign(catalogue_mechanism(), *records)
    found = diagnose(bench, identify(bench, workers=1, near=TRUTH), workers=1)
    (one,) = found.missing
    assert one.name == "stepper.detent:2.63deg"
    own = {name.rpartition(".")[2]: p for name, p in one.parameters.items()}
    assert abs(own["amplitude"].value - 0.004) < 4.0 * own["amplitude"].std_error < 1e-4
    assert abs(own["phase_deg"].value - 30.0) < 4.0 * own["phase_deg"].std_error < 2.0


def test_hum_that_the_fit_has_found_is_named():
    """Truth: 50 Hz of 5 mN m with a third of it at 150 Hz, added to a record whose rate varies."""
    command = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 10.0), (2.0, 60.0)]))
    made_by = catalogue_mechanism().with_values(TRUTH)
    torque = measured(made_by, command, np.random.default_rng(9), seconds=2.0)
    turns = 2.0 * np.pi * 50.0 * np.arange(torque.size) / RATE_HZ
    torque += 5e-3 * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    bench = replace(campaign(made_by, record("sweep", torque, command)), considered=("clock",))
    fit = identify(bench, workers=1, near={p.name: p.value for p in made_by.free})
    assert [one.name for one in fit.missing] == ["mains:50Hz"]
    found = diagnose(bench, fit, workers=1)
    assert [one.name for one in found.missing] == ["mains:50Hz"]


def test_effects_that_stand_for_something_else_are_told_from_those_that_explain():
    """Truth: the rule as the documentation has it: a half where more than noise is left, and three that imitate."""

    def score(share):
        return Score(chi_square=1000.0, dof=1, share=share, worth=1e5)

    def left(ratio):
        return SimpleNamespace(over_noise=ratio)

    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2)}) == []
    assert standing_in(left(1.05), {"a": score(0.9), "b": score(0.2)}) == ["b"]
    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.2)}) == []
    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.05)}) == ["c"]
    assert standing_in(left(1.0), {"a": score(0.9), **dict.fromkeys("bcd", score(0.2))}) == ["a", "b", "c", "d"]
    five = dict.fromkeys("abcd", score(0.9))
    assert standing_in(left(1.0), {**five, "e": score(0.9)}) == []
    assert standing_in(left(1.0), {**five, "e": score(0.2)}) == ["a", "b", "c", "d", "e"]


def test_effects_with_which_parts_of_the_records_disagree_are_named_where_they_take_nearly_all(monkeypatch):
    """Truth: the rule that the page states, at both sides of each limit."""

    def score(share):
        return Score(1000.0, 2, share, 1e5)

    def left(over_noise):
        return SimpleNamespace(over_noise=over_noise, cost=1.0)

    needed, less = {"a": score(0.95), "b": score(0.8)}, {"a": left(1.3), "b": left(1.3)}
    monkeypatch.setattr(search, "_agrees", lambda model: True)
    assert in_doubt(left(1.0), needed, less) == []
    monkeypatch.setattr(search, "_agrees", lambda model: False)
    assert in_doubt(left(1.0), needed, less) == ["b"]
    assert in_doubt(left(1.0), needed, {**less, "a": left(1.005)}) == ["a", "b"]
    assert in_doubt(left(1.3), needed, less) == []
    assert in_doubt(left(1.0), {}, {}) == []


def test_a_small_effect_is_not_named_of_records_followed_in_part():
    """Truth: less than a hundredth of what the largest explains is small, of whole records never."""
    needed = {
        name: SimpleNamespace(chi_square=c) for name, c in {"a": 1e5, "b": 1001.0, "c": 999.0, "d": 500.0}.items()
    }
    part, whole = (SimpleNamespace(is_of_whole_records=one) for one in (False, True))
    assert small_in_part(part, needed) == "d"
    assert small_in_part(part, {name: needed[name] for name in "ab"}) == ""
    assert small_in_part(part, {}) == ""
    assert small_in_part(whole, needed) == ""


def test_nothing_is_named_where_nothing_is_missing():
    """Truth: the records were made by the mechanism as it is written."""
    bench = made()
    found = mechid.diagnose(bench, identify(bench, workers=1, near=TRUTH).to_dict(), workers=1)
    assert found.missing == ()
    assert found.mechanism is None
    assert found.unexplained == 0.0
    assert "Nothing is left to explain" in found.words
    assert found.pictures.spectra == ()


def test_a_failed_fit_is_refused_with_what_to_do():
    bench = made()
    failed = {
        **identify(bench, workers=1, near=TRUTH).to_dict(),
        "grade": "failed",
        "grade_reasons": [{"text": "no start could be simulated", "next_command": "mechid check"}],
    }
    with pytest.raises(FitError, match=r"a failed fit cannot be diagnosed.*Next: mechid check"):
        diagnose(bench, failed)


def test_a_fit_that_follows_its_records_in_part_is_diagnosed_over_whole_records(fitted, lacking):
    """Truth: the harmonic that made the records, and the record that the fit says it has not followed."""
    bench, fit = fitted
    reasons = [{"cause": "used_in_part", "record": "full_23", "text": "", "next_command": ""}]
    found = diagnose(bench, {**fit.to_dict(), "grade": "C", "grade_reasons": reasons}, workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert "grade C" in found.words
    assert "full_23 among them" in found.words
    assert "grade C" not in lacking[1].words


def test_effects_are_found_from_the_first_moments_on(fitted):
    """Truth: the harmonic that made the records, five times that of the fit's, whose values are none of these."""
    bench = made({**HARMONIC, "amplitude": 0.05})
    before, _ = begun(bench, fitted[1].to_dict())
    told = []
    found = in_stretches(replace(before, q=before.problem.start, cost=np.inf), told.append)
    assert found.effects == ("stepper.torque_harmonic:3",)
    assert found.over_noise == pytest.approx(1.0, abs=0.03)
    assert found.is_of_whole_records
    values = found.problem.coordinates.values(found.q)
    (amplitude,) = (v for n, v in values.items() if "torque_harmonic" in n and n.endswith("amplitude"))
    assert amplitude == pytest.approx(0.05, rel=0.05)
    assert told[0].endswith("% of the records followed with nothing beside")
    assert told[-1] == "100.0 % of the records followed with stepper.torque_harmonic:3"


def test_a_fit_on_a_wrong_branch_holds_no_parameter(fitted):
    """Truth: the mechanism file, which says what is free; the fit has held one of these."""
    bench, fit = fitted
    estimate = fit.to_dict()
    held = {**estimate["parameters"]["gear.damping"], "status": "frozen"}
    estimate = {**estimate, "parameters": {**estimate["parameters"], "gear.damping": held}, "grade_reasons": []}

    def free(grade):
        return {p.name for p in begun(bench, {**estimate, "grade": grade})[0].base.free}

    assert free("C") == {p.name for p in bench.mechanism.free}
    assert free("C") - free("B") == {"gear.damping"}


def test_a_law_stands_beside_another(fitted):
    """Truth: the parameters that each law has of its own, and the values with which the first one stood there."""
    bench, fit = fitted
    before, _ = begun(bench, fit.to_dict())
    friction = next(law for law in before.other_laws if law.name == "output_friction")
    one = before.in_place_of(friction, friction.mechanism.with_values({"output_friction.coulomb": 0.0123}))
    backlash = next(law for law in one.other_laws if law.name == "gear.backlash")
    both = one.in_place_of(backlash, backlash.mechanism)
    assert both.laws == ("output_friction", "gear.backlash")
    assert set(both.law_parameters) == {*friction.own, *backlash.own}
    assert both.base.value("output_friction.coulomb") == 0.0123
    assert "output_friction" not in {law.name for law in both.other_laws}
    assert set(before.base.parameters) < set(one.base.parameters) < set(both.base.parameters)


def test_an_alias_is_found_from_where_the_other_effect_is():
    """Truth: offsets of the phase voltages and a detent of 7.2 deg are one, so that either leaves the same."""
    imbalance = {"offset_a": 0.06, "offset_b": -0.04}
    made_by = mechanism_from_table({**tables(), "stepper": {**CATALOGUE["stepper"], "imbalance": imbalance}}, "apart")
    made_by = made_by.with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((3, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "micro_46"))
    ]
    bench = campaign(catalogue_mechanism(), *records)
    before, _ = begun(bench, mechid.identify(bench, workers=1, near=TRUTH).to_dict())
    detent = before.fitted(before).with_effect("stepper.detent:7.2deg")
    offset = detent.exchanged("stepper.detent:7.2deg", "stepper.phase_offset")
    assert offset.terms == ("stepper.phase_offset",)
    assert offset.cost == pytest.approx(detent.cost, abs=3.0)
    values = offset.problem.coordinates.values(offset.q)
    found = {name.rpartition(".")[2]: value for name, value in values.items() if "offset_" in name}
    assert found == pytest.approx(imbalance, rel=0.05)


@pytest.mark.parametrize(
    ("outcome", "share", "asked"),
    [
        (FitOutcome.CONVERGED, 1.0, [False]),
        (FitOutcome.HORIZON, 1.0, [False]),
        (FitOutcome.HORIZON, 0.4, [False, True]),
        (FitOutcome.INTERRUPTED, 1.0, [False]),
    ],
)
def test_a_completion_searches_patiently_only_where_no_model_follows(outcome, share, asked, monkeypatch):
    """Truth: the order that the documentation gives; searches and diagnoses are stand-ins."""
    searches = []

    def search(_, *, patient=True, **__):
        searches.append(patient)
        return SimpleNamespace(outcome=outcome, grade="C", patient=patient)

    monkeypatch.setattr(completion, "identified", search)
    monkeypatch.setattr(completion, "diagnose", lambda *_, **__: SimpleNamespace(mechanism=object(), share=share))
    fit, found = completion.examined(None)
    assert searches == asked
    assert fit.patient is asked[-1]
    assert (found is None) == (outcome is FitOutcome.INTERRUPTED)


@dataclass(frozen=True)
class Fitted:
    """What a completion asks of a fit."""

    grade: Grade
    outcome: FitOutcome = FitOutcome.CONVERGED
    completed: tuple = ()


@pytest.mark.parametrize(("grades", "kept"), [("A", "A"), ("CA", "A"), ("CB", "B"), ("CC", "C")])
def test_a_completed_fit_that_is_not_followed_is_searched_again(grades, kept, monkeypatch):
    """Truth: the order that the documentation gives; searches are stand-ins, the second one begins from no values."""
    begun_near, left = [], iter(grades)

    def search(_, *, near=None, **__):
        begun_near.append(near)
        return Fitted(grade=Grade(next(left)))

    monkeypatch.setattr(completion, "identified", search)
    whole = SimpleNamespace(mechanism=SimpleNamespace(free=[SimpleNamespace(name="a", value=1.0)]))
    fit = completion.identified_with(whole, SimpleNamespace(share=1.0, steps=()))
    assert fit.grade == kept
    assert begun_near == [{"a": 1.0}, None][: len(grades)]


def backwards_after(bench, seconds):
    """Return a campaign whose records run backwards after some time, which no mechanism follows."""
    first = round(seconds * RATE_HZ)

    def one(made_record):
        (channel,) = made_record.data.channels
        torque = np.array(channel.data)
        torque[first:] = torque[first:][::-1]
        return replace(made_record, data=replace(made_record.data, channels=(replace(channel, data=torque),)))

    return replace(bench, records=tuple(map(one, bench.records)))


@pytest.mark.slow
def test_what_is_missing_is_named_from_what_can_be_followed(fitted):
    """Truth: the harmonic that made the records up to 0.2 s of 0.3; nothing made what comes after that."""
    bench = backwards_after(made({**HARMONIC, "amplitude": 0.05}), 0.2)
    estimate = {**fitted[1].to_dict(), "grade": "C", "grade_reasons": []}
    found = diagnose(bench, estimate, workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert 0.6 < found.share < 0.7
    assert f"the first {100.0 * found.share:.3g} % of all samples" in found.words
    (amplitude,) = (p for n, p in found.missing[0].parameters.items() if n.endswith("amplitude"))
    assert abs(amplitude.value - 0.05) < 4.0 * amplitude.std_error


def test_a_mechanism_completes_itself():
    """Truth: the harmonic and the parameters that made the records."""
    fit = mechid.identify(made(HARMONIC), workers=1, near=TRUTH, complete=True)
    assert fit.grade == "A"
    assert [step["added"] for step in fit.completed] == ["stepper.torque_harmonic:3"]
    own = fit.parameters["stepper.torque_harmonic.0.amplitude"]
    assert abs(own.value - 0.01) < 4.0 * own.std_error
    assert mechid.identify(made(), workers=1, near=TRUTH, complete=True).completed == ()


def test_a_fit_of_other_files_is_refused():
    bench = made()
    estimate = identify(bench, workers=1, near=TRUTH).to_dict()
    digests = dict.fromkeys(estimate["provenance"]["inputs_sha256"], "0" * 64)
    other = {**estimate, "provenance": {**estimate["provenance"], "inputs_sha256": digests}}
    assert digests
    with pytest.raises(InputFileError, match="not as in the fit; identify anew"):
        diagnose(bench, other)
