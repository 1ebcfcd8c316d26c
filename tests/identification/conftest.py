"""A campaign whose mechanism file lacks a harmonic: its fit and its diagnosis, each made once."""

from dataclasses import replace

import pytest

import mechid
from diagnosis_bench import HARMONIC, made
from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.diagnosis.diagnosis import diagnose
from once import once
from synthetic import TRUTH

KINDS = (
    "stepper.torque_harmonic",
    "stepper.detent",
    "stepper.imbalance",
    "gear.kinematic_error",
    "friction.directional",
    "record.delay",
    "clock",
)
"""What a diagnosis looks for here: no other laws, each of which has a kernel of its own to compile."""


@pytest.fixture(scope="session")
def fitted(tmp_path_factory):
    """Return a campaign that lacks a harmonic, and its fit as the file is written, which a diagnosis completes."""
    bench = replace(made(HARMONIC), considered=KINDS, options=IdentifyOptions(terms=False))
    fit = once(tmp_path_factory, "lacking_fit", lambda: mechid.identify(bench, workers=1, near=TRUTH))
    return bench, replace(fit, campaign=bench)


@pytest.fixture(scope="session")
def lacking(fitted, tmp_path_factory):
    """Return a campaign that lacks a harmonic, and its diagnosis."""
    bench, fit = fitted
    return bench, once(tmp_path_factory, "lacking_diagnosis", lambda: diagnose(fit, workers=1))
