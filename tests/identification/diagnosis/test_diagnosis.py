"""A diagnosis names what a mechanism file lacks, proposes a file that has it, and names nothing where nothing is."""

import json
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import mechid
from colours_drawn import wrong_colours
from diagnosis_bench import made
from mechid.campaign import catalogue_mechanism
from mechid.campaign.identify_options import IdentifyOptions
from mechid.campaign.mechanism_text import mechanism_text
from mechid.command import RateProfile
from mechid.diagnoses.document import PRESENTER
from mechid.diagnoses.figures import diagnosis_figures
from mechid.diagnoses.numbers import diagnosis_numbers
from mechid.errors import FitError, InputFileError
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.identify import identify
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME
from mechid.identification.result.grade import Cause, Grade, Reason
from mechid.ink.console import console_on
from mechid.reports.numbers import report_data
from synthetic import AS_WRITTEN, COMMANDS, RATE_HZ, TRUTH, campaign, measured, record

COMPLETED = ("modelled, with the effects", "residual, with the effects")
"""Of the completed model, in the colour of effects."""


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


@pytest.mark.slow
def test_it_is_found_among_all_that_is_known(fitted):
    """Truth: the harmonic that made the records; other laws are asked too."""
    bench, fit = fitted
    found = diagnose(replace(fit, campaign=replace(bench, considered=())), workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert {"friction.load_dependent", "charge_amplifier"} <= {one.name for one in found.tried}
    assert found.unexplained == 0.0


def test_the_files_of_a_diagnosis(lacking, tmp_path, capsys):
    """Truth: the contract of diagnose.json, and TOML's own reader."""
    _, found = lacking
    data = diagnosis_numbers(found)
    files = PRESENTER.write(found, data, tmp_path / "out")
    PRESENTER.print(data, console_on(), files)
    printed = capsys.readouterr().out
    content = json.loads((tmp_path / "out" / FILE_NAME).read_text())
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
    assert [
        line for _, figure in diagnosis_figures(found.pictures) for line in wrong_colours(figure, other=COMPLETED)
    ] == []
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


def test_only_what_the_campaign_names_is_looked_for(fitted):
    """Truth: a kind stands for all of its periods; what is not named is not fitted."""
    bench, fit = fitted
    found = mechid.diagnose(fit, consider=("stepper.torque_harmonic",), workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    found = diagnose(replace(fit, campaign=replace(bench, considered=("clock",))), workers=1)
    assert found.missing == ()
    with pytest.raises(
        InputFileError, match=r'consider\[1\], or --consider: found "stepper.torque_harmonics".*did you mean'
    ):
        mechid.diagnose(fit, consider=("clock", "stepper.torque_harmonics"), workers=1)


@pytest.mark.parametrize("options", [AS_WRITTEN, pytest.param(IdentifyOptions(), marks=pytest.mark.slow)])
def test_a_residual_that_nothing_explains_is_said_to_go_with_time(options):
    """Truth: the sine of 77 Hz that was added to a record whose rate varies; no grid has it, and no effect is asked."""
    command = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 10.0), (1.0, 60.0)]))
    made_by = catalogue_mechanism().with_values(TRUTH)
    torque = measured(made_by, command, np.random.default_rng(9), seconds=1.0)
    torque += 0.02 * np.sin(2.0 * np.pi * 77.0 * np.arange(torque.size) / RATE_HZ)
    bench = replace(campaign(made_by, record("sweep", torque, command)), considered=("clock",))
    near = {p.name: p.value for p in made_by.free}
    fit = identify(replace(bench, options=options), workers=1, near=near)
    found = diagnose(replace(fit, campaign=bench), workers=1)
    assert found.missing == ()
    (one,) = found.locked
    assert one.frequencies_hz[0] == pytest.approx(77.0, abs=0.5)
    assert one.share > 0.5
    assert "Nothing in the library explains the residual" in found.words
    assert "77 Hz at any rate" in found.words


def test_nothing_is_named_where_nothing_is_missing():
    """Truth: the records were made by the mechanism as it is written."""
    bench = made()
    found = mechid.diagnose(bench, identify(bench, workers=1, near=TRUTH), workers=1)
    assert found.missing == ()
    assert found.mechanism is None
    assert found.unexplained == 0.0
    assert "Nothing is left to explain" in found.words
    assert found.pictures.spectra == ()
    tried = {one.name: one.why for one in found.tried}
    assert {"stepper.detent:0.9deg", "gear.kinematic_error:1", "stepper.torque_harmonic:3"} <= tried.keys()
    assert all(re.search("of the misfit, chi-square .* is required|not looked for", why) for why in tried.values())


def test_a_failed_fit_is_refused_with_what_to_do():
    why = Reason(cause=Cause.NOT_SIMULATED, text="no start could be simulated", next_command="mechid check")
    failed = replace(identify(made(), workers=1, near=TRUTH), grade=Grade.FAILED, reasons=(why,))
    with pytest.raises(FitError, match=r"a failed fit cannot be diagnosed.*Next: mechid check"):
        diagnose(failed)


def test_a_fit_that_follows_its_records_in_part_is_diagnosed_over_whole_records(fitted, lacking):
    """Truth: the harmonic that made the records, and the record that the fit says it has not followed."""
    reasons = (Reason(cause=Cause.USED_IN_PART, record="full_23", text=""),)
    found = diagnose(replace(fitted[1], grade=Grade.C, reasons=reasons), workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert "grade C" in found.words
    assert "full_23 among them" in found.words
    assert "grade C" not in lacking[1].words


def test_a_fit_of_other_files_is_refused():
    fit = identify(made(), workers=1, near=TRUTH)
    digests = dict.fromkeys(fit.inputs_sha256, "0" * 64)
    other = replace(fit, provenance={**fit.provenance, "inputs_sha256": digests})
    assert digests
    with pytest.raises(InputFileError, match="changed since the fit; identify anew"):
        diagnose(other)
