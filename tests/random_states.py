"""Random states of a mechanism, its parameters by name, and its modes as a run would enter them."""

import numpy as np

from hand_typed_blocks import varied_friction
from layouts import LAYOUTS


def values(m):
    return dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))


def random_state(m, seed):
    """Return states by name, of the size a run meets; the gear is twisted by up to 4e-4 rad."""
    r = np.random.default_rng(seed)
    scale = {
        "i_A": 0.5,
        "i_B": 0.5,
        "omega": 8.0,
        "z_fr": 1e-3,
        "q_1": 1e-3,
        "q_2": 1e-4,
        "v_1": 0.2,
        "v_2": 0.1,
        "h_cable": 0.5,
        "h_detent": 0.5,
    }
    x = {str(s): scale.get(str(s), 0.0) * r.normal() for s in m.plant.states}
    x["alpha"] = r.uniform(-3, 3)
    x["alpha_gear"] = x["alpha"] / 50 + r.uniform(-4e-4, 4e-4)
    x["omega_gear"] = x["omega"] / 50 + 0.05 * r.normal()
    angle = r.uniform(0, 2 * np.pi)
    return x, np.array([-np.cos(angle), np.sin(angle)])


def entered(equations, x, u, p):
    """Return the mode symbols that the plant's own entry rules choose at a state, as a run would at its start."""
    plant, modes = equations.plant, [0] * len(equations.plant.switches)
    for k in (*range(len(modes)), *range(len(modes))):
        rules = equations.entry[k](x, u, equations.mode_symbols(modes), p)
        switch = plant.switches[k]
        chosen = next((mode for (_, mode), v in zip(switch.entry, rules, strict=True) if v > 0), switch.otherwise)
        modes[k] = list(switch.modes).index(chosen)
    return equations.mode_symbols(modes)


def rubbing(name, m, x, direction=None):
    """Return the kernel's parameters by name, friction as it is at a state's angles in its direction, or in another."""
    lists = LAYOUTS[name].get("friction", {})

    def orders(key):
        return tuple(h["order"] for h in lists.get(key, ()))

    of_direction = orders("position_forward"), orders("position_backward")
    direction = np.sign(x["omega"]) if direction is None else direction
    own = orders("position"), orders("output_position"), of_direction
    return varied_friction(*own, x["alpha"], x["alpha_gear"], direction, values(m))
