"""The kernel against its slow twin (DOP853 at 1e-10, located events): the accuracy that is promised.

Truth: the twin, itself held against closed forms in tests/kernel. The promise: RMS error at most 1e-5, and
maximum at most 1e-4, of the record's RMS torque.
"""

import numpy as np
import pytest

from paper import RECORDS, SWEEP, mechanism
from runs import base, rms, run_kernel, run_twin, state_after

LONG = [("full_46", "paper"), ("full_23", "paper"), ("full_92", "paper"), ("micro_46", "unit_dc")]
CASES = [
    ("full_5", "paper"),
    ("full_23", "paper"),
    ("full_46", "paper"),
    ("full_92", "paper"),
    ("micro_46", "paper"),
    ("full_46", None),
    ("micro_46", "unit_dc"),
]


def assert_promise(kernel, twin, size, note):
    error = kernel - twin
    largest = np.abs(error).max()
    note(f"RMS error {rms(error) / size:.1e}, maximum {largest / size:.1e} of the RMS torque {size:.3f} N m")
    assert rms(error) <= 1e-5 * size
    assert largest <= 1e-4 * size


@pytest.mark.parametrize(
    ("name", "housing"),
    [pytest.param(*one, marks=pytest.mark.slow) if one in LONG else one for one in CASES],
)
def test_one_second_agrees(name, housing, note):
    m, command, time_base = mechanism(housing), RECORDS[name], base(1.0)
    kernel, twin = run_kernel(m, command, time_base), run_twin(m, command, time_base)
    assert_promise(kernel.torque, twin.y[:, 0], rms(twin.y), note)
    assert [(s.before, s.after) for s in twin.switching] == list(
        zip(kernel.switching.before, kernel.switching.after, strict=True)
    )
    np.testing.assert_allclose(kernel.switching.time, [s.time for s in twin.switching], rtol=0, atol=1e-6)


@pytest.mark.parametrize("begin_s", [0.0, *(pytest.param(one, marks=pytest.mark.slow) for one in (22.0, 45.0))])
def test_two_seconds_of_the_sweep_agree(begin_s, note):
    """The twin starts from the kernel's state; sizes are relative to the whole sweep's RMS."""
    m, until = mechanism(), base(begin_s + 2.0)
    kernel, whole = run_kernel(m, SWEEP, until), run_kernel(m, SWEEP, base(60.0), substeps=1)
    begin = state_after(m, SWEEP, base(begin_s))
    first = round(begin_s * until.sample_rate_hz)
    window = base(2.0, start_s=begin_s)
    twin = run_twin(m, SWEEP, window, begin=begin)
    assert_promise(kernel.torque[first:], twin.y[:, 0], rms(whole.torque), note)
    once = whole.torque[first : kernel.torque.size] - twin.y[:, 0]
    assert np.abs(once).max() <= 1e-6, "N m at one step a sample: finer steps behind break-aways"


@pytest.mark.slow
def test_the_whole_sweep_agrees(note):
    m, time_base = mechanism(), base(60.0)
    kernel, twin = run_kernel(m, SWEEP, time_base), run_twin(m, SWEEP, time_base)
    assert_promise(kernel.torque, twin.y[:, 0], rms(twin.y), note)


def test_a_time_offset_shifts_the_whole_run(note):
    """Truth: the twin at the shifted instants; before the command begins the mechanism rests."""
    m, command, time_base = mechanism(None), RECORDS["full_92"], base(0.1)
    for offset_s in (0.00123, -0.00123):
        kernel = run_kernel(m, command, time_base, offset_s=offset_s)
        twin = run_twin(m, command, time_base, offset_s=offset_s)
        assert_promise(kernel.torque, twin.y[:, 0], rms(twin.y), note)
        assert not kernel.torque[: 13 if offset_s > 0 else 0].any()
