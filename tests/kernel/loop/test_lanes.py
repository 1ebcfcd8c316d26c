"""The sorting of directions into layers, against the Jacobians of single parameters."""

import numpy as np
import pytest

from mechid.simulation.simulator import simulate_run
from paper import RECORDS, indices, mechanism
from runs import SUBSTEPS, base, run_kernel, simulator


def mixtures(p, sensitive):
    """Return as many directions as parameters, which move 1, 2, all, none or half of them in turn, (n_p, m)."""
    rng = np.random.default_rng(5)
    counts = (1, 2, len(sensitive), 0, len(sensitive) // 2)
    out = np.zeros((p.size, len(sensitive)))
    for lane in range(len(sensitive)):
        chosen = rng.permutation(sensitive)[: counts[lane % len(counts)]]
        out[chosen, lane] = p[chosen] * rng.uniform(-1.0, 1.0, chosen.size)
    return out


@pytest.mark.parametrize("housing", ["paper", None])
def test_a_mixture_of_parameters_has_the_mixture_of_their_jacobians(housing):
    """Truth: J of single parameters times the directions; a node that several of them affect needs several layers."""
    m, command, time_base = mechanism(housing), RECORDS["full_46"], base(0.15)
    sensitive, p = indices(m), m.kernel_values()
    single = run_kernel(m, command, time_base, sensitive=sensitive)
    directions = mixtures(p, sensitive)
    made = simulator(m, command, time_base, sensitive=sensitive)
    mixed = simulate_run(made.run(p, substeps=SUBSTEPS, events=2000, directions=directions))
    weights = directions[list(sensitive)]
    assert single.switching.time.size > 5
    for found, alone in (
        (mixed.jacobian["torque"], single.jacobian["torque"]),
        (mixed.switching.sensitivity, single.switching.sensitivity),
    ):
        # Parts of a mixture may cancel, so each column is compared at the scale of its parts.
        scale = (np.abs(alone) @ np.abs(weights)).max(axis=0)
        assert np.all(np.abs(found - alone @ weights) <= 1e-10 * scale)


def test_only_a_node_that_several_parameters_of_a_direction_affect_needs_several_layers():
    """Truth: the definition of a layer, one parameter for each lane and node; single parameters add to no other."""
    m, command, time_base = mechanism(), RECORDS["full_46"], base(0.01)
    sensitive, p = indices(m), m.kernel_values()
    made = simulator(m, command, time_base, sensitive=sensitive)

    def additions(directions):
        run = made.run(p, directions=directions)
        simulate_run(run)
        module, discrete = made.kernel.module, run.buffers.discrete
        layers = discrete[module.LAYERS + module.NG]
        return discrete[module.LAYER :][: module.LAYER_SIZE * layers].reshape(layers, -1)[:, -1]

    assert additions(made.directions).size > 0
    assert not additions(made.directions).any()
    assert additions(mixtures(p, sensitive)).any()
