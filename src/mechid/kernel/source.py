"""A plant becomes the text of a module: header, sizes, physics, time loop."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib import resources

import numpy as np

from mechid.kernel import physics
from mechid.kernel.tangents import LaneWriter
from mechid.plant.plant import Plant

LANE_WIDTH = 8


@dataclass(frozen=True)
class Source:
    """A generated module and the sizes its caller needs to lay out buffers."""

    text: str
    digest: str
    lanes: int
    work: int
    lane_rows: int


def lanes_for(parameters: int) -> int:
    """Return the lane count for so many parameters: one spare, rounded up to a whole vector."""
    return -(-(parameters + 1) // LANE_WIDTH) * LANE_WIDTH if parameters else 0


def generate(plant: Plant, lanes: int) -> Source:
    """Return the module of a plant with `lanes` sensitivities (0: none; else see `lanes_for`)."""
    writer = physics.Writer(plant, lanes)
    functions = [*physics.rates(writer), physics.step(writer), *physics.guards(writer), physics.start(writer)]
    functions += [*physics.outputs(writer), physics.linear_filter(writer)]
    lane_writer = LaneWriter(writer)
    if lanes:
        functions += lane_writer.functions()
    functions.append(physics.constants(writer))
    sizes = _sizes(plant, lanes, writer, lane_writer)
    body = "\n\n".join(functions) + "\n\n" + _loop_text(bool(lanes))
    digest = hashlib.sha256((sizes + body).encode()).hexdigest()
    text = _header(plant, lanes, digest, body) + sizes + "\n\n" + body
    return Source(text, digest, lanes, _work_size(plant, writer), lane_writer.layout.rows["END"])


def _loop_text(with_lanes: bool) -> str:
    text = resources.files("mechid.kernel").joinpath("loop.py.in").read_text(encoding="utf-8")
    dropped = "# plain" if with_lanes else "# lanes"
    return "\n".join(line for line in text.splitlines() if not line.endswith(dropped)) + "\n"


def _header(plant: Plant, lanes: int, digest: str, body: str) -> str:
    operations = sum(body.count(sign) for sign in (" * ", " + ", " - "))
    names = {
        "states": plant.states, "filter states": plant.filter.states, "inputs": plant.inputs,
        "parameters": plant.parameters, "outputs": plant.outputs,
    }  # fmt: skip
    listing = "\n".join(f"    {what}: {', '.join(map(str, symbols))}" for what, symbols in names.items())
    return (
        f'"""Kernel of {plant.name} with {lanes} lanes. Made by mechid; do not edit.\n\n'
        f"digest {digest}\n{listing}\n    {operations} additions and products in the text\n"
        '"""\n\nimport math\n\nimport numpy as np\nfrom numba import njit\n\n'
        'FAST = {"contract", "arcp", "nsz", "reassoc"}\n'
    )


def _sizes(plant: Plant, lanes: int, writer: physics.Writer, lane_writer: LaneWriter) -> str:
    rows = lane_writer.layout.rows
    n_x, n_f, n_v = len(plant.states), len(plant.filter.states), len(plant.filter.inputs)
    n_c, n_m, n_y = len(writer.constants.names), len(writer.mode_symbols), len(plant.outputs)
    measured = sorted({plant.parameters.index(q) for n in writer.program.measured for q in n.outer})
    off_k = n_c + n_m
    off_x = off_k + 2 * (n_x + n_v)
    off_mid = off_x + 2 * n_x
    off_z = off_mid + 2 * n_v
    off_jump = off_z + n_f
    values = {
        "NL": lanes, "NX": n_x, "NF": n_f, "NV": n_v, "NU": len(plant.inputs), "NY": n_y,
        "NP": len(plant.parameters), "NC": n_c, "NM": n_m, "NS": len(plant.switches),
        "NP_FILTER": len(physics.filter_parameters(plant)), "N_OUTPUT_P": len(measured),
        "OFF_K": off_k, "OFF_X": off_x, "OFF_MID": off_mid, "OFF_Z": off_z, "OFF_JUMP": off_jump,
        "OFF_EVENT": off_jump + 2 * n_y,
        "ROW_S": rows["S"], "ROW_SZ": rows["SZ"], "ROW_ACC": rows["ACC"], "ROW_V0": rows["V0"],
        "ROW_V1": rows["V1"], "ROW_DTAU": rows["DTAU"],
    }  # fmt: skip
    lines = [f"{name} = {value}" for name, value in values.items()]
    return "\n".join([*lines, *_guard_tables(plant), f"OUTPUT_P = np.array({measured or [0]})"])


def _work_size(plant: Plant, writer: physics.Writer) -> int:
    n_x, n_v, n_y = len(plant.states), len(plant.filter.inputs), len(plant.outputs)
    scalars = len(writer.constants.names) + len(writer.mode_symbols) + 3 * (n_x + n_v) + 2 * n_x + 2 * n_v
    return scalars + len(plant.filter.states) + 4 * n_y


def _guard_tables(plant: Plant) -> list[str]:
    """Return the numbering of guards as text: first and count by switch and mode, targets by guard."""
    switches = plant.switches
    shape = (max(len(switches), 1), max((len(s.modes) for s in switches), default=1))
    first, count = np.zeros(shape, dtype=int), np.zeros(shape, dtype=int)
    targets: list[int] = []
    for i, switch in enumerate(switches):
        modes = list(switch.modes)
        for j, mode in enumerate(modes):
            guards = switch.guards.get(mode, ())
            first[i, j], count[i, j] = len(targets), len(guards)
            targets += [modes.index(g.target) if g.target else -1 for g in guards]
    return [
        f"MOST_GUARDS = {int(count.max())}",
        f"GUARD_FIRST = np.array({first.tolist()})",
        f"GUARD_COUNT = np.array({count.tolist()})",
        f"GUARD_TARGET = np.array({targets or [-1]})",
    ]
