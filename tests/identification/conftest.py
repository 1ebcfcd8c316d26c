"""A campaign whose mechanism file lacks a harmonic: its fit and its diagnosis, each made once."""

import pytest

import mechid
from diagnosis_bench import HARMONIC, made
from mechid.identification.diagnosis.diagnosis import diagnose
from synthetic import TRUTH


@pytest.fixture(scope="session")
def fitted():
    """Return a campaign that lacks a harmonic, and its fit."""
    bench = made(HARMONIC)
    return bench, mechid.identify(bench, workers=1, near=TRUTH)


@pytest.fixture(scope="session")
def lacking(fitted):
    """Return a campaign that lacks a harmonic, and its diagnosis."""
    bench, fit = fitted
    return bench, diagnose(fit, workers=1)
