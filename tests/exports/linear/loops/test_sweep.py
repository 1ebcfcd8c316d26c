"""Margins from swept sines. Truth: the linear loop's; a measured loop that is off by a known factor."""

import numpy as np
import pytest

from mechid.errors import FitError
from mechid.exports.linear.loops import sweep
from mechid.exports.linear.loops.closing import Loop
from mechid.exports.linear.loops.loop_file import LoopDesign
from mechid.exports.linear.loops.sampled import Sampled
from mechid.exports.linear.state_space import Matrices


def integrator(gain):
    """Return g z^-2/(z - 1), whose margins are closed forms, at 1 kHz."""
    A = np.array([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    open_loop = Sampled(
        Matrices(A, np.array([[0.0], [1.0], [0.0]]), np.array([[gain, 0.0, 0.0]]), np.zeros((1, 1))),
        1e-3,
        ("u",),
        ("y",),
    )
    return Loop(open_loop, open_loop, open_loop, open_loop)


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_a_measured_ratio_moves_the_margins_by_itself(monkeypatch, turn):
    """Truth: a loop that is 1 dB stronger has 1 dB less margin; one that lags by 2 deg has 2 deg less."""
    loop, ratio = integrator(0.1), 10.0 ** ((1.0 if turn == 0.0 else 0.0) / 20.0) * np.exp(-1j * np.radians(turn))

    def measured(_plant, _design, own, _driven, cycles, samples, _share):
        return complex(own.open.response([cycles / samples / 1e-3])[0, 0, 0] * ratio)

    monkeypatch.setattr(sweep, "measure_loop", measured)
    found = sweep.sweep_loop(None, LoopDesign(), loop, "u")
    assert len(found.frequency_hz) >= 8
    if turn == 0.0:
        assert found.gain_error_dB == pytest.approx(-1.0, abs=1e-6)
        with pytest.raises(FitError, match=r"loop of this test: a swept sine .* differ by -1 dB"):
            sweep.refuse_departure(found, "loop of this test")
    else:
        assert found.phase_error_deg == pytest.approx(-2.0, abs=1e-6)
        assert found.to_dict()["phase_error_deg"] == pytest.approx([-2.0] * len(found.frequency_hz))
        with pytest.raises(FitError, match="not linear at its rest point"):
            sweep.refuse_departure(found, "loop")


def test_crossovers_that_a_run_does_not_reach_are_left_out(monkeypatch):
    """Truth: a gain of 1e-6 crosses |L| = 1 at 0.16 mHz, so that only the phase crossover is measured."""
    monkeypatch.setattr(
        sweep, "measure_loop", lambda _p, _d, own, _i, c, n, _s: own.open.response([c / n / 1e-3])[0, 0, 0]
    )
    found = sweep.sweep_loop(None, LoopDesign(), integrator(1e-6), "u")
    assert found.frequency_hz.min() > 10.0
    assert found.gain_error_dB == pytest.approx(0.0, abs=1e-9)
