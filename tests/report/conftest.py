"""A fit made by hand: no search, every number known."""

import math

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.fit import Fit, FitOutcome, ParameterEstimate, RecordFit, StageReport
from mechid.parameter import Status

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
        "samples": 600001, "fit_percent": 97.8012, "residual_rms": 0.00199876, "noise_sigma": 0.002004,
        "offset": -0.0009104, "drift": -7.47e-5, "horizon_s": 60.0001,
    }  # fmt: skip
    return RecordFit(name=name, use=use, **(entries | changes))


@pytest.fixture
def make_fit():
    """Return a function that makes the fit, of any outcome."""

    def make(outcome=FitOutcome.CONVERGED):
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
                    name="gated growth", records={"full_46": 1.0001}, free=names, cost=math.nan,
                    evaluations=3, seconds=2.04, note="all records followed to their ends",
                ),
            ),
            outcome=outcome,
            warnings=("friction.static: at bound at 0.03 N m",),
            notes=("stepper.peak_voltage is taken as known",),
            provenance={"seed": 0, "wall_time_s": np.float64(1.5)},
        )  # fmt: skip

    return make


@pytest.fixture
def truth():
    return TRUTH
