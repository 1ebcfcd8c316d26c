"""mechid's own side of the benchmark."""

from __future__ import annotations

from functools import partial

from .problem import Output, Problem, Run

NAME = "mechid"
REMARK = "kernel as generated, default accuracy"


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False) -> Run:
    """Return the run over the whole record, compiled and loaded."""
    run = partial(run_mechid, problem, jacobian, keep_jacobian=keep_jacobian)
    run()
    return run


def run_mechid(problem: Problem, jacobian: bool, *, keep_jacobian: bool = False) -> Output:
    """Simulate `problem` with mechid's public interface; a call is what is timed.

    Parameters
    ----------
    problem : Problem
        The record. Its mechanism goes into a mechid mechanism field by field (detents as amplitude
        and phase; k_v tied to k_m; housing of the form "paper"), its command is the sweep's
        ``rate_profile = [[0, 0], [60, 120]]`` at 16 microsteps. mechid finds the edges itself.
    jacobian : bool
        Whether the derivatives of y by the fifteen `problem.PARAMETERS`, and by the record's time
        offset, are computed: block by block, as the fit does it, without the reduction.
    keep_jacobian : bool
        Whether they are also returned, in the order and coordinates of `problem.PARAMETERS`; for
        the accuracy, in a run that is not timed.

    Returns
    -------
    Output
        y at all samples and, if kept, its Jacobian.

    Raises
    ------
    NotImplementedError
        Until the kernel and the time loop are there; the benchmark then goes on without mechid.
    """
    raise NotImplementedError("mechid's simulation is not connected to the benchmark yet")
