"""The load. Truth: statics."""

import numpy as np
import pytest

from layouts import paper_with
from mechid.kernel.equations import equations_of
from mechid.kernel.equilibrium import equilibrium


def test_a_load_at_rest_shows_its_weight_to_the_transducer():
    """Truth: statics. It hangs in its gear, wound up by W sin(alpha_gear + phi)/K_s; the base carries the weight."""
    m = paper_with({"housing": None, "load": {"unbalance": {"amplitude": 0.08, "phase_deg": 30.0}}})
    plant, p = m.plant.with_outputs(("torque", "output_angle", "rotor_angle")), m.kernel_values()
    held = np.array([-np.cos(0.7), np.sin(0.7)])
    x, _ = equilibrium(plant, p, held, 0.7)
    resting = [0.0, 0.0]  # friction holds
    torque, output, rotor = equations_of(plant).outputs(x.tolist(), held.tolist(), resting, p.tolist())
    weight = 0.08 * np.sin(output + np.pi / 6)
    assert rotor / 50 - output == pytest.approx(weight / 913.47, rel=1e-6)
    assert torque == pytest.approx(-weight, rel=1e-9)
