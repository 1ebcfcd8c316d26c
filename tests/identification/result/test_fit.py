"""Result of an identification as a value. Truth: the mechanism and the numbers that it was made of."""

import pickle
from dataclasses import replace

import pytest

from fits_by_hand import fit_by_hand
from mechid.campaign import catalogue_mechanism
from mechid.errors import UsageError
from mechid.identification.result.estimate_file import write_estimate
from mechid.identification.result.fit import OPTIMUM, REBUILD
from mechid.identification.result.fit_file import read_numbers
from mechid.identification.result.missing_effects import Missing
from mechid.identification.result.parameter_estimate import ParameterEstimate

FREE, KNOWN = "gear.stiffness", "gear.damping"


def estimate(name, value, start, status):
    return ParameterEstimate(
        name=name,
        symbol="k",
        unit="N m/rad",
        value=value,
        std_error=None,
        std_error_white=None,
        start=start,
        min=None,
        max=None,
        status=status,
    )


@pytest.fixture
def fit():
    """Return a fit of a stiffness that began at 900 and came to 1000; the damping is known."""
    mechanism = catalogue_mechanism().with_free((FREE,)).with_values({FREE: 1000.0, KNOWN: 0.4})
    parameters = {FREE: estimate(FREE, 1000.0, 900.0, "free"), KNOWN: estimate(KNOWN, 0.4, 0.4, "known")}
    return fit_by_hand(mechanism, parameters=parameters)


def test_it_knows_its_values_and_where_it_started(fit):
    assert fit.values == {FREE: 1000.0, KNOWN: 0.4}
    assert fit.start_mechanism.value(FREE) == 900.0
    assert fit.start_mechanism.value(KNOWN) == 0.4
    assert fit.start_mechanism.plant is fit.mechanism.plant


def test_it_knows_the_files_that_it_was_made_of(fit):
    assert fit.inputs_sha256 == {}
    assert replace(fit, provenance={"inputs_sha256": {"campaign.toml": "ab"}}).inputs_sha256 == {"campaign.toml": "ab"}


def test_without_its_campaign_what_needs_it_is_refused(fit):
    for asked in ("required_campaign", "optimum"):
        with pytest.raises(UsageError, match="the fit does not hold its campaign; give campaign="):
            getattr(fit, asked)


def test_added_terms_are_told_from_disturbances_of_records(fit):
    rest = {"words": "", "parameters": {}, "chi_square": 40.0, "dof": 1, "share": 0.5, "p_value": 0.0}
    term = Missing(name="stepper.detent:0.9deg", records=(), toml="", block="stepper.detent", **rest)
    clock = Missing(name="clock", records=(), toml="", **rest)
    assert replace(fit, missing=(clock, term)).added_terms == (term,)


def test_its_optimum_is_neither_copied_nor_pickled(fit):
    vars(fit)[OPTIMUM] = object()
    assert OPTIMUM not in vars(replace(fit))
    assert OPTIMUM not in vars(pickle.loads(pickle.dumps(fit)))
    assert pickle.loads(pickle.dumps(fit)).values == fit.values


def test_its_source_is_the_place_in_messages(fit, tmp_path):
    assert fit.source == "the fit"
    write_estimate(fit, tmp_path / "estimate.json")
    assert read_numbers(tmp_path).source == str(tmp_path / "estimate.json")


def test_what_it_has_not_is_said(fit):
    with pytest.raises(AttributeError, match="'Fit' object has no attribute 'gear'"):
        _ = fit.gear


def test_an_attribute_error_inside_a_property_is_told_as_it_is(fit, monkeypatch):
    def fails(*given):
        raise AttributeError("no attribute inside")

    monkeypatch.setattr(f"{REBUILD}.rebuild_optimum", fails)
    with pytest.raises(AttributeError, match="no attribute inside"):
        _ = fit.optimum
    with pytest.raises(AttributeError, match="no attribute 'optima'"):
        _ = fit.optima
