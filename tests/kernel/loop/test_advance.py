"""The time loop: a run that stops and goes on is one run. Truth: the run in one piece."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.command import Timing
from mechid.simulation.simulator import Simulator, TimeBase
from paper import RECORDS, indices, mechanism
from runs import base, run_kernel


@pytest.mark.parametrize("block", [1, 7, 333, 5000])
@pytest.mark.parametrize("housing", ["paper", None])
def test_blocks_of_any_size_give_the_same_bits(housing, block):
    """Truth: the run in one piece; across stick/slip and edges, with sensitivities."""
    m, command, time_base = mechanism(housing), RECORDS["full_46"], base(0.1)
    whole = run_kernel(m, command, time_base, sensitive=indices(m), block=time_base.samples)
    parts = run_kernel(m, command, time_base, sensitive=indices(m), block=block)
    np.testing.assert_array_equal(parts.torque, whole.torque)
    np.testing.assert_array_equal(parts.jacobian["torque"], whole.jacobian["torque"])
    np.testing.assert_array_equal(parts.rate["torque"], whole.rate["torque"])
    np.testing.assert_array_equal(parts.switching.time, whole.switching.time)


@pytest.mark.parametrize("block", [1, 7, 333])
def test_blocks_of_any_size_give_the_same_bits_without_sensitivities(block):
    """Truth: the run in one piece."""
    m, command, time_base = mechanism(), RECORDS["full_46"], base(0.1)
    whole = run_kernel(m, command, time_base, block=time_base.samples)
    np.testing.assert_array_equal(run_kernel(m, command, time_base, block=block).torque, whole.torque)


def test_runs_with_and_without_sensitivities_are_one_run():
    """Truth: each other; only the order of rounding differs."""
    m, command = mechanism(), RECORDS["full_46"]
    plain, both = run_kernel(m, command, base(0.5)), run_kernel(m, command, base(0.5), sensitive=indices(m))
    np.testing.assert_allclose(plain.torque, both.torque, rtol=0, atol=1e-11)


@pytest.mark.parametrize("rate_hz", [1e4, 2048.0, 3e4])
@pytest.mark.parametrize("offset_s", [0.0, 0.001, 0.1, 0.1024, 0.3, 0.7])
@pytest.mark.parametrize("sensitive", [False, True])
def test_blocks_end_at_the_same_samples_wherever_the_motion_begins(rate_hz, offset_s, sensitive):
    """Truth: the run in one piece; the command begins on a sample, and a thousandth of one before and behind it."""
    m, command = mechanism(), RECORDS["full_46"]
    time_base = TimeBase(rate_hz, round(0.75 * rate_hz))
    on_sample = round(offset_s * rate_hz) / rate_hz
    run = Simulator(m.plant, command, time_base, [(i,) for i in indices(m)] if sensitive else (), latest_s=1.0)
    ends = []
    for off in (0.0, 1e-3 / rate_hz, -1e-3 / rate_hz):
        begun = [run.run(m.kernel_values(), timing=Timing(on_sample + off), block=size) for size in (97, 30000)]
        parts = list(_copied(begun[0]))
        (whole,) = _copied(begun[1])
        ends.append([b.stop for b in parts])
        for name in ("y", "rate", "jacobian"):
            together = np.concatenate([getattr(b, name) for b in parts])
            np.testing.assert_array_equal(together, getattr(whole, name))
        still = begun[1].resting
        assert not whole.y[:still].any()
        assert still in (round(offset_s * rate_hz), round(offset_s * rate_hz) + 1)
        assert whole.y[still:].any()
    assert ends[0] == ends[1] == ends[2]


def _copied(run):
    """Yield a run's blocks, each with arrays of its own."""
    for block in run.blocks():
        yield replace(block, y=block.y.copy(), rate=block.rate.copy(), jacobian=block.jacobian.copy())
