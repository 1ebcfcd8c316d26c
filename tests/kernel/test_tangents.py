"""The kernel's sensitivities against central differences of the kernel, and against the twin's.

Truth: the difference quotient, where it converges: where two neighbouring step sizes agree to 1e-5 of the
column's norm. Where a switch comes or goes between the displaced runs, or a sample meets one, it need not;
such a pair of parameter and record is told with its event. And the twin's variational equations, as a second
way to the same derivatives.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from paper import RECORDS, indices, mechanism
from runs import base, run_kernel, run_twin

STEPS = (1e-4, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7)
"""Of a parameter's value."""
STEPS_S = (1e-5, 3e-6, 1e-6, 3e-7, 1e-7)
"""Of a time offset, in s; smaller ones drown in the rounding of the filter's propagator."""
AGREEMENT = 1e-5
LONG_CASES = [("full_5", 1.0), ("full_46", 1.0), ("full_92", 1.0), ("sweep", 3.0)]


@dataclass(frozen=True)
class Verdict:
    """How one column fares: whether the quotient converges, and how far J is from it, relative to its norm."""

    name: str
    convergence: float
    error: float
    event: str

    @property
    def converged(self):
        return self.convergence <= AGREEMENT


def verdicts(m, command, time_base, substeps):
    """Return a verdict for each sensitive parameter and for the time offset."""
    sensitive = indices(m)
    at = run_kernel(m, command, time_base, substeps=substeps, sensitive=sensitive)
    columns = at.jacobian["torque"]
    for column, index in enumerate(sensitive):

        def displaced(step, index=index):
            p = m.kernel_values()
            h = step * abs(p[index])
            p[index] += h
            return run_kernel(m, command, time_base, substeps=substeps, p=p), h

        yield verdict(at.parameters[column], columns[:, column], displaced, STEPS, at)

    def shifted(step):
        return run_kernel(m, command, time_base, substeps=substeps, offset_s=step), step

    # at the first sample the torque has a kink in time: before it the mechanism rests
    yield verdict("time_offset_s", -at.rate["torque"], shifted, STEPS_S, at, first=1)


def verdict(name, column, displaced, steps, at, first=0):
    """Compare a column with its difference quotients."""
    quotients, counts = [], []
    for step in steps:
        (above, h), (below, _) = displaced(step), displaced(-step)
        quotients.append((above.torque - below.torque)[first:] / (2 * h))
        counts.append((above.switching.time.size, below.switching.time.size))
    size = np.linalg.norm(column[first:]) or 1.0
    gaps = [np.linalg.norm(a - b) / size for a, b in pairwise(quotients)]
    best = int(np.argmin(gaps))
    error = np.linalg.norm(quotients[best + 1] - column[first:]) / size
    return Verdict(name, gaps[best], error, event_behind(quotients[best + 1] - quotients[best], counts, at, first))


def event_behind(gap, counts, at, first):
    """Say which event a quotient that does not converge has met: one that comes or goes, or passes a sample."""
    n = at.switching.time.size
    changed = [pair for pair in counts if pair != (n, n)]
    if changed:
        return f"{n} switches become {changed[-1]} between the displaced runs"
    worst = at.time[first + int(np.argmax(np.abs(gap)))]
    if not n:
        return f"no switch; steps between edge and sample change in number near {worst:.4f} s"
    nearest = at.switching.time[np.argmin(np.abs(at.switching.time - worst))]
    return f"quotients differ most at the sample at {worst:.4f} s; the nearest switch is {nearest - worst:+.1e} s away"


def assert_agree(found, note):
    """Assert what is promised, and tell the share and the exclusions."""
    left_out = [v for v in found if not v.converged]
    worst = max((v.error for v in found if v.converged), default=np.nan)
    note(f"{len(found) - len(left_out)} of {len(found)} quotients converge, largest error {worst:.1e}")
    for v in left_out:
        note(f"left out: {v.name}: quotients agree to {v.convergence:.1e}; {v.event}")
    assert len(left_out) <= np.ceil(0.1 * len(found))
    for v in found:
        assert not v.converged or v.error <= AGREEMENT, v


@pytest.mark.parametrize(
    ("name", "duration_s"),
    [
        pytest.param("full_23", 1.0, marks=pytest.mark.slow),
        ("micro_46", 1.0),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in LONG_CASES),
    ],
)
def test_they_agree_with_central_differences(name, duration_s, note):
    """All stick/slip of the sweep falls into its first two seconds."""
    m = mechanism()
    assert_agree(list(verdicts(m, RECORDS[name], base(duration_s), 2)), note)


@pytest.mark.parametrize("name", [pytest.param("full_5", marks=pytest.mark.slow), "full_46"])
def test_they_agree_where_the_torque_itself_jumps(name, note):
    """With a rigid housing a sample is the mean of a jump over its interval, and so is its derivative."""
    assert_agree(list(verdicts(mechanism(None), RECORDS[name], base(1.0), 2)), note)


@pytest.mark.slow
def test_they_agree_with_central_differences_over_the_whole_sweep(note):
    assert_agree(list(verdicts(mechanism(), RECORDS["sweep"], base(60.0), 2)), note)


@pytest.mark.parametrize("housing", ["paper", pytest.param("unit_dc", marks=pytest.mark.slow), None])
def test_they_agree_with_the_twin_s(housing, note):
    """Truth: variational equations and saltation in plain matrices, DOP853; steps here fine enough for 1e-6."""
    m, command, time_base = mechanism(housing), RECORDS["full_46"], base(0.15)
    sensitive = indices(m)
    kernel = run_kernel(m, command, time_base, substeps=16, sensitive=sensitive)
    twin = run_twin(m, command, time_base, sensitive=sensitive)
    assert len(twin.switching) > 5
    for column, name in enumerate(kernel.parameters):
        expected = twin.jacobian[:, 0, column]
        error = np.linalg.norm(kernel.jacobian["torque"][:, column] - expected) / np.linalg.norm(expected)
        assert error <= 1e-6, name
    expected = twin.rate[:, 0]
    assert np.linalg.norm(kernel.rate["torque"] - expected) <= 1e-6 * np.linalg.norm(expected)
    instants = np.array([s.sensitivity for s in twin.switching])
    np.testing.assert_allclose(kernel.switching.sensitivity, instants, rtol=1e-6, atol=1e-8 * np.abs(instants).max())
