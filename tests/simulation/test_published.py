"""What is known of the paper's mechanism from elsewhere: an independent simulator, and the publication.

Values of an independent simulator (not mechid's) are regression: the paper's estimates, 5.7 V,
cosine waveform, detents without phases, housing. They carry two digits. What the paper itself publishes is
validation: where the lines and the largest torque lie.
"""

import numpy as np
import pytest

from mechid.signal.spectrum import amplitude_spectrum, line_amplitude
from paper import SWEEP, constant, without_detent_phases
from runs import RATE_HZ, base, rms, run_kernel

NO_SECOND_DETENT = {"stepper.detent.1.amplitude": 0.0}


def torque(command, duration_s, changes=None):
    """Return samples over a duration, its end not among them, so that whole periods fit."""
    return run_kernel(without_detent_phases(changes), command, base(duration_s)).torque[:-1]


@pytest.fixture(scope="module")
def sweep():
    return torque(SWEEP, 60.0)


def test_independent_simulator_full_steps_at_46():
    """Regression: +-0.80 N m, and 0.73 N m in the 46 Hz line over 1 s, from 45 deg."""
    y = torque(constant(46.0), 1.0)
    assert y.max() == pytest.approx(0.80, abs=0.005)
    assert y.min() == pytest.approx(-0.80, abs=0.005)
    assert line_amplitude(y, RATE_HZ, 46.0) == pytest.approx(0.73, abs=0.005)


def test_independent_simulator_microsteps_at_46():
    """Regression: 0.06 N m in the start transient, +-0.04 N m after 0.5 s, 0.021 N m at 46 Hz."""
    y = torque(constant(46.0, microsteps=16, start_angle_deg=0.0), 1.0)
    assert np.abs(y[:5000]).max() == pytest.approx(0.06, abs=0.005)
    assert np.abs(y[5000:]).max() == pytest.approx(0.04, abs=0.005)
    assert line_amplitude(y, RATE_HZ, 46.0) == pytest.approx(0.021, abs=0.0005)


def test_independent_simulator_sweep(sweep):
    """Regression: 0.34 N m at 46.3 s."""
    assert np.abs(sweep).max() == pytest.approx(0.34, abs=0.005)
    assert np.abs(sweep).argmax() / RATE_HZ == pytest.approx(46.3, abs=0.05)


def test_published_resonance_of_mass_on_gear():
    """Published: sqrt(K_s/J_m)/2pi = 46.9 Hz, 72.7 Hz for the catalogue's stiffness.

    Seen in a run: while friction holds the rotor after a step, the load swings at that frequency.
    """
    for stiffness, published in ((913.47, 46.9), (2200.0, 72.7)):
        held = {"gear.stiffness": stiffness, "gear.damping": 0.05, "friction.static": 0.03, "friction.viscous": 0.02}
        y = torque(constant(2.0), 0.98, held)[6000:]
        crossings = np.flatnonzero(np.diff(np.signbit(y)))
        seen = (crossings.size - 1) / 2 / ((crossings[-1] - crossings[0]) / RATE_HZ)
        assert np.sqrt(stiffness / 0.010534) / (2 * np.pi) == pytest.approx(published, abs=0.05)
        assert seen == pytest.approx(published, rel=2e-3)


def test_published_lines_of_full_steps_at_46():
    """Published: the step rate's line at 46 Hz, on the mode, stands far above; harmonics at 92 and 138 Hz."""
    y = torque(constant(46.0), 3.0)[10000:]
    frequency, amplitude = amplitude_spectrum(y, RATE_HZ, "hann")
    assert frequency[amplitude.argmax()] == 46.0
    for line in (46.0, 92.0, 138.0):
        near = amplitude[np.abs(frequency - line) < 10.0]
        assert amplitude[frequency == line][0] == near.max()
        assert near.max() > 100 * np.median(near)


def test_published_sweep_is_largest_where_the_second_detent_meets_the_mode(sweep):
    """Published: the maximum is at 46 s and 92 steps/s, where the 3.6 deg detent excites the 46 Hz mode."""
    largest_s = np.abs(sweep).argmax() / RATE_HZ
    assert largest_s == pytest.approx(46.0, abs=0.5)
    assert 2.0 * largest_s == pytest.approx(92.0, abs=1.0)
    window = slice(455_000, 475_000)
    frequency, amplitude = amplitude_spectrum(sweep[window], RATE_HZ, "hann")
    assert frequency[amplitude.argmax()] == pytest.approx(46.5, abs=1.0)
    without = torque(SWEEP, 60.0, NO_SECOND_DETENT)
    assert rms(without[window]) < 0.1 * rms(sweep[window])
