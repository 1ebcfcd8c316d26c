"""Short ways to run kernel and twin on a command, for the tests of the simulation."""

import numpy as np

from kernel_state import twin_state
from mechid.command import Timing
from mechid.kernel.twin import simulate_twin
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from paper import SENSITIVE

SUBSTEPS = 2
"""Steps a sample at which the promise of 1e-5 holds on the paper's records at 10 kHz."""
RATE_HZ = 10_000.0
LANES = len(SENSITIVE)


def base(duration_s, *, rate_hz=RATE_HZ, start_s=0.0):
    """Return a time base that includes both ends."""
    return TimeBase(rate_hz, round(duration_s * rate_hz) + 1, start_s)


def simulator(mechanism, command, time_base, *, sensitive=(), latest_s=0.0, lanes=LANES):
    """Return a simulator; all of a plant share one kernel, whose lanes hold every parameter of the paper."""
    alone = tuple((i,) for i in sensitive)
    return Simulator(mechanism.plant, command, time_base, alone, latest_s, capacity=lanes)


def run_kernel(
    mechanism, command, time_base, *, substeps=SUBSTEPS, sensitive=(), p=None, offset_s=0.0, block=1024, lanes=LANES
):
    """Return the kernel's trajectory."""
    made = simulator(mechanism, command, time_base, sensitive=sensitive, latest_s=abs(offset_s), lanes=lanes)
    p = mechanism.kernel_values() if p is None else p
    return simulate_run(made.run(p, substeps=substeps, timing=Timing(offset_s), block=block, events=2000))


def run_twin(mechanism, command, time_base, *, sensitive=(), begin=None, offset_s=0.0, tolerance=1e-10):
    """Return the twin's run of the same."""
    times = time_base.times - offset_s
    return simulate_twin(
        mechanism.plant,
        command.excitation(max(times[-1], 0.0) + time_base.interval_s),
        times,
        mechanism.kernel_values(),
        start_angle_rad=command.start_angle_rad,
        begin=begin,
        sensitive=sensitive,
        tolerance=tolerance,
    )


def state_after(mechanism, command, time_base, *, substeps=SUBSTEPS, sensitive=()):
    """Return where the kernel stands at the last sample of a time base, as a state of the twin."""
    made = simulator(mechanism, command, time_base, sensitive=sensitive)
    run = made.run(mechanism.kernel_values(), substeps=substeps)
    for _ in run.blocks():
        pass
    return twin_state(run)


def rms(values):
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
