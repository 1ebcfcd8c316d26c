"""A linear stage on an open-loop stepper against its resolver: one sine per 0.25 mm of travel.

Acceptance test of motorised slits (2020), read from the log by the project's own lines: 43 s at 0.2500 mm/s; resolver
less step counter is a sine of 20.5 um with a period of 0.250 mm, the next one 1.5 um at half of it, by an independent
fit. No file says whether the resolver or the screw makes it. Case I of docs/validation.md.
"""

import math

import numpy as np
import pytest

import mechid

pytestmark = pytest.mark.data
SPEED_MM_S = 0.25
SAMPLE_RATE_HZ = 100.0
PERIOD_MM = 0.25
RESOLVER = "IOC_TEST:ec0-s4-EL7211-Enc-PosAct"


@pytest.fixture(scope="module")
def position(data_folder):
    """Return the resolver's position in mm at 100 Hz, (n,)."""
    log = data_folder / "stepper_slit_resolver_ecmc" / "axis1_resolver_openloop.log"
    lines = (line.split() for line in log.read_text(encoding="utf-8").splitlines())
    return np.array([float(value) for name, _, _, value in lines if name == RESOLVER])


def test_a_look_finds_the_period_and_the_amplitude(position, figure):
    """Truth: the independent fit; tolerances 0.1 % and 2 %."""
    entry = mechid.make_record("slit", {"position": 1e-3 * position}, sample_rate_hz=SAMPLE_RATE_HZ)
    (record,) = mechid.look(entry).to_dict()["records"]
    lines = sorted(record["channels"][0]["lines"], key=lambda line: -line["amplitude"])[:2]
    period = SPEED_MM_S / lines[0]["frequency_hz"]
    figure("slit stage: period by look", period, least=0.999 * 0.25, most=1.001 * 0.25, unit="mm")
    amplitude = 1e6 * lines[0]["amplitude"]
    figure("slit stage: amplitude by look", amplitude, least=0.98 * 20.5, most=1.02 * 20.5, unit="um")
    assert SPEED_MM_S / lines[1]["frequency_hz"] == pytest.approx(PERIOD_MM / 2.0, rel=1e-3)


@pytest.fixture(scope="module")
def fit(position):
    """Return the fit of the first 10 s to a stage whose screw errs once and twice per 0.25 mm; 1 mm stands for 1 rad.

    The motor follows each step at once: its values are those of no data sheet.
    """
    free = {"amplitude": {"value": 0.005, "min": 0.0, "max": 0.1}, "phase_deg": {"value": 0.0, "min": -180, "max": 180}}
    mechanism = mechid.make_mechanism(
        {
            "stepper": {
                "poles": 100,
                "peak_voltage": 5.7,
                "rotor_inertia": 8.9e-6,
                "coil_resistance": 9.9,
                "coil_inductance": 0.01,
                "torque_constant": 0.384,
            },
            "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 0.0061},
            "gear": {
                "ratio": 2.0 * math.pi / PERIOD_MM,
                "stiffness": 100.0,
                "damping": 0.1,
                "kinematic_error": [{"order": order, **free} for order in (1, 2)],
            },
            "load": {"inertia": 1e-4},
        }
    )
    # One turn of the screw per 0.25 mm is taken to be 200 full steps, which the files do not say.
    command = mechid.make_command("micro", microsteps=4, rate=200.0 * SPEED_MM_S / PERIOD_MM)
    samples = {"output_angle": position[:1001] - position[0]}
    record = mechid.make_record("slit", samples, sample_rate_hz=SAMPLE_RATE_HZ, command=command)
    keys = [f"gear.kinematic_error.{k}.{key}" for k in (0, 1) for key in ("amplitude", "phase_deg")]
    stages = [{"records": ["slit"], "free": keys}]
    return mechid.identify(mechid.make_campaign(mechanism, [record], entries={"stage": stages}))


@pytest.mark.slow
def test_a_fit_of_the_output_angle_finds_the_amplitudes(fit, figure):
    """Truth: the independent fit, 20.5 and 1.5 um; tolerances 2 % and three stated errors."""
    first, second = (fit.parameters[f"gear.kinematic_error.{k}.amplitude"] for k in (0, 1))
    figure("slit stage: amplitude by a fit", 1e3 * first.value, least=0.98 * 20.5, most=1.02 * 20.5, unit="um")
    assert 1e3 * second.value == pytest.approx(1.5, abs=3e3 * second.std_error)


@pytest.mark.slow
@pytest.mark.xfail(reason="no block for the error of an angle sensor over its turn, so nothing names it as an alias")
def test_a_fit_says_that_sensor_and_screw_cannot_be_told_apart(fit):
    """Truth: the record itself, at one speed in one direction."""
    said = " ".join([*fit.warnings, *fit.notes])
    assert "sensor" in said
