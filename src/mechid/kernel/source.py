"""Source text of a plant's kernel module: header, sizes, physics, time loop."""

from __future__ import annotations

import ast
import hashlib
from importlib import resources

import numpy as np

from mechid.kernel import physics, runge_kutta
from mechid.kernel.places import Places
from mechid.kernel.switching import guards
from mechid.kernel.tangents import WIDTH, LaneWriter
from mechid.plant.plant import Plant

GENERATOR = (
    "source.py",
    "physics.py",
    "runge_kutta.py",
    "switching.py",
    "places.py",
    "pointers.py",
    "fours.py",
    "compiler.py",
    "tangents.py",
    "program.py",
    "expressions.py",
    "schedule.py",
)
LOOP = ("sines", "memory", "filter", "guards", "lanes", "switches", "advance")
"""Modules common to all plants, in the order in which a kernel needs them; the plant's functions follow the first."""
TERMS = 48
"""Largest number of terms in the series of the filter's propagator; enough for rates up to ten per step."""
FEWEST_GROUPS = 5
"""Least number of groups of lanes: with 20 lanes, all commands share one kernel of a mechanism like the paper's, which
has 20 parameters. A group more than a run needs costs it 0.7 %, a second kernel 5 s."""


def lanes_for(parameters: int) -> int:
    """Return the lane count for a number of directions: whole groups, at least `FEWEST_GROUPS` of them."""
    return max(whole_groups(parameters), FEWEST_GROUPS * WIDTH)


def whole_groups(parameters: int) -> int:
    """Return the lane count for a number of directions where no kernel is shared: whole groups."""
    return -(-parameters // WIDTH) * WIDTH


def fingerprint(plant: Plant, lanes: int) -> str:
    """Return the hash that names a plant's kernel, from its structure, the lanes, and mechid's generator."""
    # The generator's own text is part of the hash: a changed generator must not find kernels of an older one.
    generator = "".join(
        resources.files("mechid.kernel").joinpath(name).read_text(encoding="utf-8")
        for name in (*GENERATOR, *(f"loop/{name}.py" for name in LOOP))
    )
    return hashlib.sha256(f"{plant.digest} {lanes} {generator}".encode()).hexdigest()[:24]


def generate(plant: Plant, lanes: int) -> str:
    """Return the source of a plant's module with `lanes` lanes for sensitivities (see `lanes_for`)."""
    writer = physics.Writer(plant)
    functions = [
        runge_kutta.turns(writer),
        *physics.rates(writer),
        runge_kutta.step(writer),
    ]
    functions += [*guards(writer), physics.start(writer)]
    functions += [*physics.outputs(writer), physics.linear_filter(writer)]
    lane_writer = LaneWriter(writer)
    # Constants come last: the other functions add to them while they are written.
    functions += [*lane_writer.functions(), physics.constants(writer)]
    numbers = _numbers(plant, lanes, writer)
    rows = lane_writer.layout.rows
    numbers |= {
        "TERMS": TERMS,
        "NT": lane_writer.coefficients,
        "NG": lanes // WIDTH,
        "NSEED": lane_writer.seeds,
        "NFORCED": len(lane_writer.seeded),
        "LANES_PER_GROUP": WIDTH,
        "GROUP_SIZE": rows["END"] * WIDTH,
    }
    parts = {"LANES": rows["END"] * lanes} | _work_parts(numbers, plant.most_guards)
    sizes = _size_lines(numbers | {f"ROW_{name}": row for name, row in rows.items()}, parts)
    # A group of lanes that moves nothing but the filter skips the drive train.
    moved = [int(k in lane_writer.drive_parameters) for k in range(len(plant.parameters))]
    tables = [*_guard_tables(plant), *lane_writer.tables, f"IN_DRIVE = np.array({moved})"]
    # The plant's functions call the sines, and the rest of the loop calls the plant's functions.
    first, *others = (text_of_loop("mechid.kernel", name) for name in LOOP)
    body = "\n\n".join([first, *functions, *others])
    names = _place_lines(writer.at)
    return _header(plant, lanes, body) + "\n".join([*sizes, *names, *tables]) + "\n\n\n" + body


def text_of_loop(package: str, name: str) -> str:
    """Return the text of a module of a package's loop under its title, without its imports."""
    text = resources.files(package).joinpath(f"loop/{name}.py").read_text(encoding="utf-8")
    tree = ast.parse(text)
    body = next(node for node in tree.body[1:] if not isinstance(node, ast.Import | ast.ImportFrom))
    decorators = getattr(body, "decorator_list", [])
    first = decorators[0].lineno if decorators else body.lineno
    rule, title = "# " + "-" * 93, (ast.get_docstring(tree) or name).splitlines()
    lines = [rule, *(f"# {line}".rstrip() for line in title), rule, ""]
    return "\n".join([*lines, *text.splitlines()[first - 1 :]]) + "\n"


def _header(plant: Plant, lanes: int, body: str) -> str:
    operations = sum(body.count(sign) for sign in (" * ", "*", " + ", " - "))
    names = {
        "states": plant.states,
        "filter states": plant.filter.states,
        "inputs": plant.inputs,
        "parameters": plant.parameters,
        "outputs": plant.outputs,
    }
    listing = "\n".join(f"    {what}: {', '.join(map(str, symbols))}" for what, symbols in names.items())
    return (
        f'"""Kernel of {plant.name} with {lanes} lanes. Made by mechid; do not edit.\n\n'
        f"structure {plant.digest}\n{listing}\n    {operations} additions and products in the text\n"
        '"""\n\nfrom __future__ import annotations\n\nimport math\n\nimport numpy as np\nfrom numba import njit\n\n'
        "from mechid.kernel.compiler import ENTRY, INNER\n"
        "from mechid.kernel.fours import copy_four, put_four, put_turned\n"
        "from mechid.kernel.pointers import apart, in_vectors, numbers\n\n"
        'FAST = {"contract", "arcp", "nsz"}\n'
    )


def _numbers(plant: Plant, lanes: int, writer: physics.Writer) -> dict[str, int]:
    return {
        "NL": lanes,
        "NX": len(plant.states),
        "NF": len(plant.filter.states),
        "NV": len(plant.filter.inputs),
        "NU": len(plant.inputs),
        "NY": len(plant.outputs),
        "NP": len(plant.parameters),
        "NC": len(writer.constants.names),
        "NM": len(writer.mode_symbols),
        "NS": len(plant.switches),
        "NPF": len(physics.filter_parameters(plant)),
        "NPOINT": len(writer.point),
    }


def _work_parts(n: dict[str, int], guards: int) -> dict[str, int]:
    """Return the size of each part of the workspace after the lanes, in order."""
    turns = n["NPOINT"] - n["NX"]
    both, width = n["NX"] + n["NV"], n["NF"] + 3 * n["NV"]
    square, prop = (1 + n["NPF"]) * n["NF"] ** 2, (1 + n["NPF"]) * n["NF"] * width
    return {
        "X": n["NX"],
        "X_TURN": turns,
        "X_NEW": n["NX"],
        "X_NEW_TURN": turns,
        "X_TRY": n["NX"],
        "X_TRY_TURN": turns,
        "POINTS": 4 * n["NPOINT"],
        "PACKED": 4 * n["NPOINT"],
        "ONE": 1,
        "SCALE": n["NL"] * n["NSEED"],
        "TIME": 1,
        "Z": n["NF"],
        "U": n["NU"],
        "M": n["NM"],
        "C": n["NC"],
        "K": both,
        "K_NEW": both,
        "K_EVENT": both,
        "MID": n["NV"],
        "MID_TRY": n["NV"],
        "KNOWN": 1,
        "CLOSE": 1,
        "PINNED": n["NX"],
        "Z_NEW": n["NF"],
        "DZ": n["NPF"] * n["NF"],
        "A": n["NF"] ** 2,
        "B": n["NF"] * n["NV"],
        "DA": n["NPF"] * n["NF"] ** 2,
        "DB": n["NPF"] * n["NF"] * n["NV"],
        "POWER": square,
        "PRODUCT": square,
        "REGULAR": prop,
        "OTHER": prop,
        "TABLE": (TERMS + 2) * prop,
        "JUMP": 2 * n["NY"],
        "JUMP_LANES": n["NY"] * n["NL"],
        "X_P": n["NX"] * n["NP"],
        "G_OLD": n["NS"] * guards,
        "G_NEW": n["NS"] * guards,
        "G_SLOPE": guards,
        "TANGENT": 4 * n["NT"],
        "PAIR": 2 * n["NY"],
        "DOT_PAIR": 2 * n["NY"],
        "J_PAIR": 2 * n["NY"] * n["NL"],
        "Y_X": n["NY"] * (n["NX"] + n["NF"]),
        "Y_P": n["NY"] * n["NP"],
        "G_X": guards * n["NX"],
        "G_P": guards * n["NP"],
    }


def _size_lines(numbers: dict[str, int], parts: dict[str, int]) -> list[str]:
    """Return the assignments of all sizes, and of start and end of each part of the workspace.

    Positions, and the value for none, are NumPy integers: Numba would compile a function again for each plain
    integer that it is called with.
    """
    first, lines = 0, [f"{name} = {value}" for name, value in numbers.items()] + ["NONE = np.int64(-1)"]
    for name, size in parts.items():
        lines.append(f"AT_{name}, END_{name} = np.int64({first}), np.int64({first + size})")
        first += size
    return [*lines, f"SIZE = {first}"]


def _place_lines(places: Places) -> list[str]:
    """Return the assignments of the named positions, one line per part.

    These too are NumPy integers: Numba 0.68 miscounts references to arrays that are indexed by literal integers.
    """
    return [
        ", ".join(f"AT_{part}_{i}" for i in single) + f", = (np.int64(AT_{part} + i) for i in {tuple(single)})"
        for part, single in places.named_positions.items()
    ]


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
        f"MOST_GUARDS = {plant.most_guards}",
        f"GUARD_FIRST = np.array({first.tolist()})",
        f"GUARD_COUNT = np.array({count.tolist()})",
        f"GUARD_TARGET = np.array({targets or [-1]})",
    ]
