"""The electro-mechanical positioning system; truth: the benchmark's published values, and an independent fit's RMS.

A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System Identification
Benchmarks, 2019.
"""

import numpy as np
import pytest

from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.signal.decimation import decimate

pytestmark = [pytest.mark.data, pytest.mark.slow]
PUBLISHED = {
    "mass": (95.1089, 0.1085, "kg"),
    "viscous": (203.5034, 1.146, "N s/m"),
    "coulomb": (20.3935, 0.1012, "N"),
    "offset": (-3.1648, 0.0444, "N"),
}
GAIN = 35.15065188248547


def test_inverse_dynamics_with_the_readers_channels(data_folder, figure):
    """mechid offers no inverse dynamics: this least squares is the test's, the channels are the reader's.

    The position is low-passed at 100 Hz without delay, differentiated twice, and all is decimated by 10.
    """
    from scipy.signal import butter, filtfilt

    channels = (
        ChannelSpec(quantity="force", column="vir", unit="N", gain=GAIN),
        ChannelSpec(quantity="position", column="qm", unit="m"),
    )
    record = read_record(data_folder / "EMPS" / "DATA_EMPS.mat", RecordSpec(name="e", path="e", channels=channels))
    q = filtfilt(*butter(4, 100.0, fs=record.sample_rate_hz), record.channel("position").data)
    v = np.gradient(q, record.sample_interval_s)
    columns = (np.gradient(v, record.sample_interval_s), v, np.sign(v), np.ones_like(v))
    inside = slice(50, -50)
    W = np.stack([decimate(c[inside], 10) for c in columns], axis=1)
    F = decimate(record.channel("force").data[inside], 10)
    found = np.linalg.lstsq(W, F, rcond=None)[0]
    for value, (name, (published, sigma, unit)) in zip(found, PUBLISHED.items(), strict=True):
        figure(f"EMPS: inverse dynamics, {name}", value, least=published - sigma, most=published + sigma, unit=unit)


@pytest.fixture(scope="module")
def symmetric(example, identified):
    return identified(example("emps"), "--seed", "1")[0]


@pytest.fixture(scope="module")
def by_direction(example, identified):
    return identified(example("emps_by_direction"))[0]


def test_open_loop_from_force_to_position(symmetric, figure):
    figure(
        "EMPS: force to position, symmetric friction",
        1e3 * symmetric.records["emps"].residual_rms,
        most=2.55,
        unit="mm RMS",
    )


def test_open_loop_with_friction_by_direction(by_direction, figure):
    figure(
        "EMPS: force to position, friction by direction",
        1e3 * by_direction.records["emps"].residual_rms,
        most=2.05,
        unit="mm RMS",
    )


def test_the_exact_dependence_is_reported(by_direction):
    """Truth: F_0 and Coulomb friction of both directions enter as F_0 - T_c a alone, moving and at rest."""
    frozen = {name: p.reason for name, p in by_direction.parameters.items() if p.status == "frozen"}
    dependent = [name for name, reason in frozen.items() if "the smallest singular value is" in reason]
    assert dependent == ["friction.asymmetry"]
    assert "drive.offset and friction.asymmetry" in frozen["friction.asymmetry"]
    assert set(frozen) <= {"friction.asymmetry", "load.start_rate"}  # of which the record may say less than its range
