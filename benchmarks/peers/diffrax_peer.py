"""diffrax: Tsitouras' method with a PID step control that knows the step edges; compiled by XLA for the processor."""

from __future__ import annotations

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from .problem import Output, Run
from .sliding import OMEGA, Window, rates, torque

MOST_STEPS = 1_000_000


def prepare(window: Window, *, tolerance: float) -> Run:
    """Return the run over the window, one call."""
    jax.config.update("jax_enable_x64", val=True)
    edges, voltages = jnp.asarray(window.borders[1:-1]), jnp.asarray(window.voltages)
    control = diffrax.ClipStepSizeController(diffrax.PIDController(rtol=tolerance, atol=tolerance), jump_ts=edges)

    def field(t, x, c):
        u = voltages[jnp.searchsorted(edges, t, side="right")]
        return jnp.stack(rates(x, u, c, jnp.sin, jnp.cos))

    @jax.jit
    def solve(start, c):
        first, last = window.samples[0], window.samples[-1]
        return diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Tsit5(),
            first,
            last,
            1e-5,
            start,
            args=c,
            saveat=diffrax.SaveAt(ts=jnp.asarray(window.samples)),
            stepsize_controller=control,
            max_steps=MOST_STEPS,
            adjoint=diffrax.ForwardMode(),
        ).ys

    named = window.coefficients(window.problem.mechanism.estimated())

    def run() -> Output:
        states = np.asarray(solve(window.start, named)).T
        window.checked(states[OMEGA])
        return Output(torque(states, named), window.first)

    return run
