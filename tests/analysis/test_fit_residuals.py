"""Residuals of a fit from its folder. Truth: the files; tests/test_folder_or_memory.py: they equal computed ones."""

import json
import math

import pytest

from estimates import free, record, write
from fits_by_hand import fit_by_hand
from mechid.analysis.fit_residuals import FitResiduals, is_simulated
from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED
from mechid.analysis.residual_file import FORMAT
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.fit_file import read_numbers

OWN = {"gear.stiffness": free(913.0, 0.5)}


def test_a_record_is_summed_up_as_the_estimate_says(tmp_path):
    fit = read_numbers(write(tmp_path / "A", {"x": record(0.002, effective=500.0, microsteps=4)}, OWN))
    (summary,) = FitResiduals(fit).summaries.values()
    torque = summary.channels["torque"]
    assert (torque.samples, torque.effective_samples, torque.residual_rms) == (10_000, 500.0, 0.002)
    assert (summary.command["microsteps"], summary.judged_from_s) == (4, None)


def test_a_number_that_is_none_is_not_a_number(tmp_path):
    fit = read_numbers(write(tmp_path / "A", {"x": record(None)}, OWN))
    torque = FitResiduals(fit).summaries["x"].channels["torque"]
    assert math.isnan(torque.residual_rms)
    assert math.isnan(torque.fit_percent)


def test_records_without_validation_have_no_summary(tmp_path):
    entry = record(0.002)
    del entry["validation"]
    fit = read_numbers(write(tmp_path / "A", {"x": record(0.002), "y": entry}, OWN))
    assert list(FitResiduals(fit).summaries) == ["x"]


def test_a_damaged_validation_is_refused_with_its_place(tmp_path):
    entry = record(0.002)
    del entry["validation"]["channels"]["torque"]["samples_sha256"]
    fit = read_numbers(write(tmp_path / "A", {"x": entry}, OWN))
    with pytest.raises(InputFileError, match=r"A/estimate\.json: no 'samples_sha256'; .* identify anew"):
        _ = FitResiduals(fit).summaries


def test_torques_are_those_of_residual_json(tmp_path):
    fit = read_numbers(write(tmp_path / "A", {"x": record(0.002)}, OWN))
    assert FitResiduals(fit).torques is None
    at = {"rate": 46.0, "windows": 2, "duration_s": 1.0, "sigma": [1e-6] * len(TRACKED)}
    at |= {"amplitude": [None] + [1e-3] * (len(TRACKED) - 1), "density": [0.0] * CENTRES_HZ.size}
    own = {"stepping": "full", "microsteps": 1, "noise_sigma": 2e-3, "sample_rate_hz": 1e4, "rates": [at]}
    content = {"format": FORMAT, "orders": list(TRACKED), "records": {"x": own}, "provenance": fit.provenance}
    (fit.folder / "residual.json").write_text(json.dumps(content), encoding="utf-8")
    (found,) = FitResiduals(fit).torques
    assert (found.name, found.noise_sigma, found.rates[0].rate) == ("x", 2e-3, 46.0)
    assert math.isnan(found.rates[0].amplitude[0])
    assert FitResiduals(fit).components is None


def test_a_fit_that_is_nowhere_has_none():
    for name in ("summaries", "torques", "components"):
        with pytest.raises(UsageError, match="does not hold its campaign"):
            getattr(FitResiduals(fit_by_hand(None)), name)


def test_a_report_of_the_same_fit_says_that_records_were_simulated(tmp_path):
    fit = read_numbers(write(tmp_path / "A", {}, OWN))
    assert not is_simulated(fit)
    (fit.folder / "report.json").write_text(json.dumps({"synthetic": True, "provenance": {}}), encoding="utf-8")
    assert not is_simulated(fit)
    told = {"synthetic": True, "provenance": fit.provenance}
    (fit.folder / "report.json").write_text(json.dumps(told), encoding="utf-8")
    assert is_simulated(fit)
    assert is_simulated(fit_by_hand(None, synthetic=True))
