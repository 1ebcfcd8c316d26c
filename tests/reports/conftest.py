"""A fit made by hand: no search, every number known."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import synthetic
from mechid.analysis import ChannelValidation, RecordValidation, validate
from mechid.analysis.order_tracking import OrderError
from mechid.analysis.validation import BandError
from mechid.campaign import Stage, catalogue_mechanism
from mechid.command import Command, RateProfile
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit, StageReport
from mechid.identification.result.grade import FitOutcome, Grade
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.record_result import RecordFit
from mechid.parameter import Status
from mechid.reports.files import write_report
from mechid.reports.numbers import report_data
from mechid.signal import LjungBox, TheilInequality
from once import once
from synthetic import COMMANDS, displaced, measured

TRUTH = {"stepper.coil_resistance": 9.9, "stepper.detent.0.phase_deg": -179.0, "gear.stiffness": 913.47}
SIGMAS = {"stepper.coil_resistance": 0.0123, "stepper.detent.0.phase_deg": 0.5, "gear.stiffness": 0.5}
VALUES = {"stepper.coil_resistance": 9.92345, "stepper.detent.0.phase_deg": 179.0, "gear.stiffness": 912.97}
AT_BOUND = "friction.static"


def estimate(q, mechanism):
    status = Status.AT_BOUND if q.name == AT_BOUND else q.status
    return ParameterEstimate(
        name=q.name,
        symbol=q.declaration.symbol,
        unit=q.declaration.unit,
        value=VALUES.get(q.name, mechanism.value(q.name)),
        std_error=SIGMAS.get(q.name),
        std_error_white=SIGMAS.get(q.name),
        start=mechanism.value(q.name),
        min=q.min if q.is_free and not q.is_periodic else None,
        max=q.max if q.is_free and not q.is_periodic else None,
        status=str(status),
        reason="the optimum lies on or beyond the bound" if status is Status.AT_BOUND else "",
    )


def record(name, use="estimate", **changes):
    entries = {
        "samples": 600001,
        "fit_percent": 97.8012,
        "residual_rms": 0.00199876,
        "noise_sigma": 0.002004,
        "offset": -0.0009104,
        "drift": -7.47e-5,
        "horizon_s": 60.0001,
    }
    return RecordFit(name=name, use=use, **(entries | changes))


@pytest.fixture
def make_fit():
    """Return a function that makes the fit, of any grade."""

    def make(grade=Grade.A, reasons=()):
        before = catalogue_mechanism()
        names = tuple(SIGMAS)
        return Fit(
            mechanism=before.with_values(VALUES),
            parameters={name: estimate(q, before) for name, q in before.parameters.items()},
            correlation_names=names,
            correlation=np.eye(3),
            covariance=np.diag([s**2 for s in SIGMAS.values()]),
            records={
                "full_46": record("full_46"),
                "sweep": record("sweep", "validate", offset=None, drift=None, fit_percent=math.nan),
            },
            stages=(
                StageReport(
                    name="gated growth",
                    records={"full_46": 1.0001},
                    free=names,
                    cost=math.nan,
                    evaluations=3,
                    seconds=2.04,
                    note="all records followed to their ends",
                ),
            ),
            outcome=FitOutcome.CONVERGED,
            warnings=("friction.static: at bound at 0.03 N m",),
            notes=("stepper.peak_voltage counts as known",),
            provenance={"seed": 0, "wall_time_s": np.float64(1.5)},
            grade=grade,
            reasons=reasons,
        )

    return make


@pytest.fixture
def truth():
    return TRUTH


def channel(order):
    return ChannelValidation(
        quantity="torque",
        unit="N*m",
        samples=600001,
        samples_sha256="ab" * 32,
        fit_percent=96.4321,
        residual_rms=0.00234567,
        theil=TheilInequality(coefficient=0.0182, bias=2.7e-28, variance=0.125, covariance=0.875),
        whiteness=LjungBox(statistic=41.0, lags=25, p_value=0.0231, largest=-0.0456),
        effective_samples=412345.6,
        spectrum_hz=np.arange(3.0),
        measured_density=np.ones(3),
        residual_density=np.ones(3),
        bands=(BandError(centre_hz=1000.0, measured_rms=0.5, residual_rms=0.001),),
        orders=(order,),
    )


@pytest.fixture
def validation():
    """Return the validation of the two records, every number known."""
    resolved = OrderError(
        order=0.5,
        windows=225,
        measured=0.159345,
        modelled=0.162345,
        amplitude_error_percent=1.8827,
        phase_error_deg=-3.456,
        peak_rate=92.78,
        peak_measured=0.3414,
        peak_modelled=0.35,
    )
    lost = OrderError(
        order=4.0,
        windows=1,
        measured=0.0001,
        modelled=0.0002,
        amplitude_error_percent=None,
        phase_error_deg=None,
        peak_rate=46.0,
        peak_measured=0.0001,
        peak_modelled=0.0002,
    )
    pairs = (("full_46", "estimate", lost), ("sweep", "validate", resolved))
    return {
        name: RecordValidation(name=name, use=use, command={"waveform": "cosine"}, channels={"torque": channel(order)})
        for name, use, order in pairs
    }


HOSTILE = "<img src=x onerror=document.title='taken'> <script> \"quoted\" 'µ' " + 60 * "long"
"""A folder's name that would be markup where it is not escaped."""


@pytest.fixture(scope="session")
def reported(tmp_path_factory):
    """Return a campaign of a record and a sweep held out, its fit, validation, and the folder of its report."""
    return once(tmp_path_factory, "reported", lambda: _reported(tmp_path_factory.mktemp("reported")))


def _reported(folder):
    start = displaced(synthetic.truth(), {"gear.stiffness": 1.01, "gear.damping": 1.02})
    rng = np.random.default_rng(5)
    sweep = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (2.0, 60.0)]))
    records = [
        synthetic.record(name, measured(synthetic.truth(), command, rng, seconds=seconds), command, use=use)
        for name, command, use, seconds in (
            ("full_46", COMMANDS["full_46"], "estimate", 0.3),
            ("sweep", sweep, "validate", 2.0),
        )
    ]
    stage = Stage(records=("full_46",), window_s=None, free=("gear.stiffness", "gear.damping"))
    campaign = replace(
        synthetic.campaign(start, *records, stages=(stage,)), path=Path("/nowhere") / HOSTILE / "campaign.toml"
    )
    fit = identify(campaign, workers=1)
    validation = validate(campaign, fit)
    data = report_data(fit, synthetic=True, validation=validation)
    files = write_report(data, campaign, fit, validation, folder)
    return SimpleNamespace(campaign=campaign, fit=fit, validation=validation, data=data, folder=folder, files=files)
