"""Blocks of one's own: a friction law, a load, a gear in a Python file, with declarations and equations changed."""

import tomllib
from pathlib import Path
from typing import Any

from fuzz.draw import Draw
from fuzz.kinds.tomls import SEEDS, load_mechanism
from fuzz.tree import changed, damaged, plain, toml
from fuzz.trial import Kind

HEAD = """
from sympy import Function, I, Max, Piecewise, Symbol, exp, log, nan, oo, sign, sin, sqrt, symbols, zoo

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.friction import ROTOR, set_valued
"""
FRICTION = """
def law():
    T_c, b, omega_g, x, T_drive, t = symbols("T_c b_g omega_g x T_drive t")
    sigma, omega = ROTOR.sigma, ROTOR.omega
    return set_valued(
        ROTOR,
        (
            Declaration(key="dry", symbol="T_c", unit="N m", meaning="dry friction", lower={lower}, source="a"),
            Declaration(key={key}, symbol={symbol}, unit={unit}, meaning="grease at rest", lower=0.0, source="a"),
            Declaration(key="thinning_rate", symbol="omega_g", unit="rad/s", meaning="a speed", lower=0.0, source="a"),
        ),
        sliding={equation},
        holds={holds},
        reference="a",
    )
"""
LOAD = """
def law():
    a, v, T, J, W, G, p, theta_0, x, omega = symbols("alpha_gear omega_gear T_applied_in J_m W_u G p theta_0 x omega")
    return Block(
        name="unbalanced_load",
        table={table},
        declarations=(
            Declaration(key="inertia", symbol="J_m", unit={unit}, meaning="inertia", lower={lower}, source="a"),
            Declaration(key={key}, symbol={symbol}, unit="N m", meaning="m c g", lower=0.0, source="a"),
        ),
        inputs={inputs},
        rates={rates},
        initial={initial},
        outputs={outputs},
    )
"""
PARTS = {
    FRICTION: {
        "lower": ("0.0", "-1.0", "1.0", "float('nan')", "None", "'a'"),
        "key": ("'grease'", "'dry'", "''", "3", "None", "'a.b'", "'static'"),
        "symbol": ("'b_g'", "'T_c'", "'x'", "''", "3", "'omega'", "'import'", "'T_m'"),
        "unit": ("'N m s/rad'", "''", "'furlong'", "None", "'9**9**9'"),
        "equation": (
            "T_c * sigma + b * omega / sqrt(1 + sigma * omega / omega_g)",
            "T_c * sigma",
            "0",
            "1 / 0",
            "x",
            "T_c * sigma + x",
            "T_c * nan",
            "oo",
            "zoo",
            "I * T_c",
            "T_c * exp(exp(omega))",
            "'T_c'",
            "None",
            "T_c * sigma + log(omega)",
            "Function('f')(omega)",
            "Piecewise((T_c, omega > 0))",
            "T_c * t",
            "T_c * sign(omega)",
            "Max(T_c, b)",
            "T_drive",
            "T_c ** T_c ** T_c",
            "[T_c]",
            "T_c > b",
        ),
        "holds": ("(T_c, T_c)", "(T_c,)", "T_c", "(x, x)", "(0, 0)", "(-T_c, T_c)", "()", "None", "(oo, oo)"),
    },
    LOAD: {
        "table": ("'load'", "'friction'", "''", "'nothing'", "None", "3"),
        "lower": ("0.0", "-1.0", "float('inf')", "None"),
        "unit": ("'kg m2'", "''", "None"),
        "key": ("'unbalance'", "'inertia'", "''", "None"),
        "symbol": ("'W_u'", "'J_m'", "'alpha_gear'", "None"),
        "inputs": ("(T,)", "()", "T", "(T, T)", "(x,)", "(omega, T)", "None", "('T',)"),
        "rates": (
            "{{a: v, v: (T - W * sin(a)) / J}}",
            "{{a: v}}",
            "{{}}",
            "{{a: v, v: T / (J - J)}}",
            "{{a: v, v: x}}",
            "{{a: v, v: nan}}",
            "{{a: v, v: 0}}",
            "{{a: a, v: v}}",
            "None",
            "{{'a': v}}",
            "{{a: v, v: T / 0.0}}",
            "{{T: v, v: a}}",
        ),
        "initial": (
            "{{a: theta_0 / (p / 2) / G, v: 0}}",
            "{{}}",
            "{{a: 0}}",
            "{{a: oo, v: 0}}",
            "{{a: x, v: 0}}",
            "{{a: v, v: a}}",
            "None",
            "{{x: 0}}",
        ),
        "outputs": (
            "{{'alpha_gear': a, 'omega_gear': v, 'T_load': T}}",
            "{{}}",
            "{{'alpha_gear': a}}",
            "{{'alpha_gear': a, 'omega_gear': v, 'T_load': nan}}",
            "{{'T_load': T, 'x': x}}",
            "None",
            "{{'alpha_gear': a, 'omega_gear': v, 'T_load': T, 'T_fr': a}}",
        ),
    },
}
"""What may stand in each place, the right one first."""
ENDS = (
    "raise ValueError('no')",
    "raise SystemExit",
    "law = 3",
    "law = law()",
    "law = None",
    "def law(x): pass",
    "law = Block",
    "class law: pass",
    "import nothing_of_this_name",
    "law = lambda: law()",
    "del law",
    "x = (",
    "def law(): raise KeyError",
    "def law(): return Block",
    "law = [law]",
)
ENTRIES: dict[str, tuple[str, dict[str, Any]]] = {
    FRICTION: ("friction", {"dry": {"value": 0.004, "min": 0.0, "max": 0.05}, "grease": 0.006, "thinning_rate": 20.0}),
    LOAD: ("load", {"inertia": 0.0105, "unbalance": 0.1}),
}


def write(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a block, and a mechanism file that names it."""
    text = draw.choice((FRICTION, LOAD))
    parts = {place: options[0] for place, options in PARTS[text].items()}
    for place in draw.sample(list(parts), draw.choice((0, 1, 1, 1, 2))):
        parts[place] = draw.choice(PARTS[text][place])
    filled = text.format(**{place: part.format() for place, part in parts.items()})
    end = draw.choice(ENDS) if draw.chance(0.2) else ""
    body = f"{HEAD}{filled}\n{end}\n"
    (folder / "law.py").write_bytes(damaged(draw, body, 0.05))
    table, entries = ENTRIES[text]
    whole = tomllib.loads((SEEDS / "mechanism.toml").read_text())
    own = {"block": "law.py:law", **entries}
    whole[table] = changed(draw, own) if draw.chance(0.3) else own
    (folder / "mechanism.toml").write_text(toml(whole))
    return {"tree": plain(whole)}


def read(folder: Path, written: dict[str, Any]) -> None:
    """Read the mechanism, compare its numbers, and wire its plant."""
    from mechid.campaign.mechanism_file import load_mechanism as read_file

    plant = read_file(folder / "mechanism.toml").plant
    if not plant.states or not plant.digest:
        raise AssertionError("a plant without states")
    load_mechanism(folder, written)


OWN_BLOCKS = (Kind("own_block", write, read, weight=2),)
