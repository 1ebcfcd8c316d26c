"""One record by heyoka: Taylor series between step edges, stick and slip as terminal events.

Run by itself, in an environment that has heyoka and NumPy and need not have mechid:

    python heyoka_side.py RUN.npz OUT.npz

RUN.npz holds `values` (JSON), `edges` (E,) s, `voltages` (E + 1, 2), `angle` (rad, electrical), `interval` (s) and
`samples`; OUT.npz gets `torque` (samples,) N m, `switches` and `version`.
"""

import json
import math
import sys

import heyoka as hy
import numpy as np

VOLTAGE_A, VOLTAGE_B, DIRECTION = range(3)
"""Runtime parameters: both phase voltages in V, and the direction of sliding."""
NAMES = ("i_A", "i_B", "alpha", "omega", "alpha_gear", "omega_gear", "z", "z_rate")
OMEGA = NAMES.index("omega")
STUCK, MOST_EVENTS = 0, 2


def torques(v, s):
    """Return the motor's torque, and those that the gear exerts on rotor and load."""
    x = v["half_poles"] * s["alpha"]
    motor = v["k_m"] * (s["i_A"] * hy.sin(x) + s["i_B"] * hy.cos(x))
    for k in (1, 2):
        motor -= v[f"detent_{k}"] * hy.sin(v[f"detent_order_{k}"] * s["alpha"] + v[f"detent_phase_{k}"])
    twist, rate = s["alpha"] / v["G"] - s["alpha_gear"], s["omega"] / v["G"] - s["omega_gear"]
    load = v["K_s"] * twist + v["D"] * rate
    return motor, load / v["G"], load


def system(v, s, sliding):
    """Return the equations of motion, stuck or sliding."""
    motor, rotor, load = torques(v, s)
    x = v["half_poles"] * s["alpha"]
    resulting = (
        motor - rotor - v["viscous"] * s["omega"] - v["coulomb"] * hy.par[DIRECTION] if sliding else hy.expression(0.0)
    )
    rates = {
        "i_A": (hy.par[VOLTAGE_A] - v["R"] * s["i_A"] - v["k_m"] * s["omega"] * hy.sin(x)) / v["L"],
        "i_B": (hy.par[VOLTAGE_B] - v["R"] * s["i_B"] - v["k_m"] * s["omega"] * hy.cos(x)) / v["L"],
        "alpha": s["omega"],
        "omega": resulting / v["J_rot"],
        "alpha_gear": s["omega_gear"],
        "omega_gear": load / v["J_m"],
        "z": s["z_rate"],
        "z_rate": v["w_0"] ** 2 * (v["K_res"] * resulting - s["z"]) - 2.0 * v["zeta"] * v["w_0"] * s["z_rate"],
    }
    return [(s[name], rates[name]) for name in NAMES]


class Bench:
    """The three integrators of the motion, stuck and sliding either way, and the one state that they hand on."""

    def __init__(self, values):
        self.v, s = values, dict(zip(NAMES, hy.make_vars(*NAMES), strict=True))
        motor, rotor, load = torques(values, s)
        self.pull = hy.cfunc([motor - rotor], list(s.values()))
        self.torque = hy.cfunc([-(s["z"] + load)], list(s.values()))
        self.of = {
            mode: hy.taylor_adaptive(system(values, s, mode != STUCK), np.zeros(len(NAMES)), t_events=events)
            for mode, events in {
                STUCK: [
                    hy.t_event(motor - rotor - side * values["static"], direction=way)
                    for side, way in ((1.0, hy.event_direction.positive), (-1.0, hy.event_direction.negative))
                ],
                1: [hy.t_event(s["omega"], direction=hy.event_direction.negative)],
                -1: [hy.t_event(s["omega"], direction=hy.event_direction.positive)],
            }.items()
        }
        self.switches = 0

    def run(self, edges, voltages, angle, interval, samples):
        """Return the torque of a record that starts at rest, currents settled, rotor where it is commanded."""
        v = self.v
        u = v["U"] * voltages
        alpha = angle / v["half_poles"]
        state = np.array([u[0, 0] / v["R"], u[0, 1] / v["R"], alpha, 0.0, alpha / v["G"], 0.0, 0.0, 0.0])
        mode, t, out = self._at_rest(state), 0.0, np.empty((samples, len(NAMES)))
        out[0], done = state, 1
        ends = [*edges[edges < (samples - 1) * interval], (samples - 1) * interval]
        for end, held in zip(ends, u, strict=False):
            mode = self._at_rest(state) if mode == STUCK else mode
            while t < end:
                stop = done + max(math.floor((end - t_of(done, interval)) / interval * (1 + 1e-15) + 1e-9) + 1, 0)
                grid = np.array([t, *(t_of(k, interval) for k in range(done, stop))])
                state, t, seen, ended = self._advance(mode, state, t, grid, end, held)
                out[done : done + len(seen)] = seen
                done += len(seen)
                if ended:
                    state[OMEGA] = 0.0
                    mode, self.switches = self._at_rest(state), self.switches + 1
        out[done:] = state
        return self.torque(np.ascontiguousarray(out.T))[0]

    def _at_rest(self, state):
        """Return how a rotor at rest goes on: held, or released in the direction of the pull."""
        pull = float(self.pull(state)[0])
        return STUCK if abs(pull) < self.v["static"] * (1.0 - 1e-12) else int(np.sign(pull))

    def _advance(self, mode, state, t, grid, end, held):
        """Carry the state to the end or to the first event; return it, its time, states at the grid, if an event."""
        own = self.of[mode]
        own.reset_cooldowns()
        own.time, own.state[:], own.pars[:] = t, state, [*held, mode][: len(own.pars)]
        seen = np.empty((0, state.size))
        if grid.size > 1:
            outcome, *_, states = own.propagate_grid(grid)
            seen = states[1:]
            if is_event(outcome):
                return own.state.copy(), own.time, seen, True
        outcome = own.propagate_until(end)[0]
        return own.state.copy(), own.time, seen, is_event(outcome)


def t_of(k, interval):
    """Return the instant of a sample, s."""
    return k * interval


def is_event(outcome):
    """Tell whether a propagation was ended by a terminal event; these are numbered from -1 downwards."""
    if outcome == hy.taylor_outcome.err_nf_state:
        raise SystemExit(f"heyoka: {outcome}")
    return -MOST_EVENTS <= int(outcome) < 0


def main():
    """Work out one record."""
    run = np.load(sys.argv[1])
    bench = Bench(json.loads(str(run["values"])))
    torque = bench.run(run["edges"], run["voltages"], float(run["angle"]), float(run["interval"]), int(run["samples"]))
    np.savez(sys.argv[2], torque=torque, switches=bench.switches, version=hy.__version__)


if __name__ == "__main__":
    main()
