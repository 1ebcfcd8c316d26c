"""Nastran models: a Craig-Bampton pair made here, NAS2CAM pairs that come with pyYeti; fields and bytes are changed.

Without pyYeti, which reads them, this kind is left out.
"""

import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.records_read import damaged
from fuzz.kinds.tomls import finite
from fuzz.trial import Kind, Misread

GRIDS = (3, 7)
TURNED = "10"
"""A frame whose axes are others than the basic one's."""


def write(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write one of the two pairs."""
    pairs = solved_pairs()
    if pairs and draw.chance(0.4):
        return _solved(draw, folder, draw.choice(pairs))
    return _craig_bampton(draw, folder)


@cache
def solved_pairs() -> tuple[tuple[bytes, bytes], ...]:
    """Return the NAS2CAM pairs among the tests of pyYeti that are installed with it."""
    spec = importlib.util.find_spec("pyyeti")
    if spec is None or spec.origin is None:
        return ()
    places = sorted((Path(spec.origin).parent / "tests" / "nas2cam").glob("*.op2"))
    return tuple((p.read_bytes(), p.with_suffix(".op4").read_bytes()) for p in places)


def _solved(draw: Draw, folder: Path, pair: tuple[bytes, bytes]) -> dict[str, Any]:
    """Write a pair with bytes changed, or two halves of different pairs."""
    other = draw.choice(solved_pairs()) if draw.chance(0.2) else pair
    (folder / "s.op2").write_bytes(pair[0])
    (folder / "s.op4").write_bytes(other[1])
    done = {"file": "s.op2", "grids": [8, 16], "mass": None, "damaged": False}
    for name in ("s.op2", "s.op4"):
        done = damaged(draw, folder / name, done, 0.35)
    return done


def _craig_bampton(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write two grids joined by springs and one mode, as EXTSEOUT does, with fields changed."""
    from pyyeti.nastran import op4

    size = 6 * len(GRIDS) + 1
    mass = np.diag([draw.uniform(1.0, 20.0) for _ in range(size)])
    springs = np.array([draw.uniform(1e3, 1e5) for _ in range(6)])
    stiffness = np.zeros((size, size))
    for k, spring in enumerate(springs):
        stiffness[np.ix_([k, k + 6], [k, k + 6])] = spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiffness[-1, -1] = draw.uniform(1e3, 1e5)
    told: list[float] | None = np.diag(mass).tolist()
    if draw.chance(0.35):
        told, changed = None, draw.choice((mass, stiffness))
        changed[draw.randrange(size), draw.randrange(size)] = draw.number()
    matrices = {"kxx": stiffness, "mxx": mass}
    if draw.chance(0.15):
        told, name = None, draw.choice(("kxx", "mxx"))
        odd = (np.zeros((0, 0)), np.ones((3, 2)), 1j * mass, np.full((size, size), np.nan), mass[:6, :6], mass[:1])
        matrices[name] = draw.choice(odd)
    if draw.chance(0.1):
        told = None
        matrices[draw.choice(("gxx", "bxx", "long_name_of_it"))] = matrices.pop(draw.choice(("kxx", "mxx")))
    op4.write(
        str(folder / "s.op4"),
        list(matrices),
        list(matrices.values()),
        binary=draw.chance(0.6),
        digits=draw.choice((9, 16)),
        sparse=draw.choice(("dense", "bigmat", "nonbigmat", "auto")),
        endian=draw.choice(("=", "<", ">")),
    )
    is_exact, frame = not draw.chance(0.3), draw.choice(("0", TURNED))
    lines = _cards(draw, frame, changed=not is_exact)
    (folder / "s.asm").write_text("\n".join(lines) + "\n")
    done = {
        "file": "s.op4",
        "grids": list(GRIDS),
        "mass": told if is_exact and frame != TURNED else None,
        "damaged": False,
    }
    for name in ("s.op4", "s.asm"):
        done = damaged(draw, folder / name, done)
    return done


def _cards(draw: Draw, frame: str, *, changed: bool) -> list[str]:
    """Return the lines of the assembly file."""
    ids = [*(str(g) for grid in GRIDS for g in (grid, grid)), "110", "110"]
    cards = [
        ["$ SE101 ASSEMBLY FILE"],
        ["SEBULK", "101", "EXTOP4", "", "MANUAL", "", "", "101"],
        ["SECONCT", "101", "0", "", "NO"],
        ["", *ids],
        ["CORD2R", "10", "0", "0.0", "0.0", "0.0", "1.0", "0.0", "0.0"],
        ["", "0.0", "1.0", "0.0"],
        *(["GRID", str(g), "0", f"{100.0 * g}", "0.", "300.", frame] for g in GRIDS),
        ["SPOINT", "110"],
    ]
    if changed:
        at = draw.randrange(1, len(cards))
        how = draw.randrange(5)
        if how == 0:
            del cards[at]
        elif how == 1:
            cards.insert(at, list(draw.choice(cards)))
        elif how == 2:
            other = draw.choice(("/proc/self/status", "s.asm", "no.asm", "../up.asm"))
            cards.insert(at, [f"{draw.choice(('INCLUDE', 'include', 'Include '))} '{other}'"])
        else:
            card = cards[at]
            odd = (
                *draw.text().splitlines()[:1],
                str(draw.whole()),
                repr(draw.number()),
                "",
                "1+",
                "GRID",
                "1.5-3",
                "THRU",
            )
            card[draw.randrange(len(card))] = draw.choice(odd)
    return [",".join(card) for card in cards]


def read(folder: Path, written: dict[str, Any]) -> None:
    """Read the structure; the whole mass that its modes hold is that of the matrix."""
    from mechid.structure import Location, Selection, read_structure

    first, second = written["grids"]
    selection = Selection(
        interface=Location(first, "rz"),
        line_of_sight={"x": (Location(second, "rx"), Location(first, "ry", 0.5))},
        damping=0.01,
        mass_unit_kg=1.0,
        length_unit_m=1.0,
    )
    structure = read_structure(folder / written["file"], selection, axis="rz")
    finite(structure)
    if written["damaged"] or written["mass"] is None:
        return
    inertia = 1.0 / float(np.sum(np.square(np.asarray(structure.model.interface))))
    if abs(inertia / written["mass"][5] - 1.0) > 1e-6:
        raise Misread(f"inertia: {inertia} where {written['mass'][5]} was written")


NASTRAN = (Kind("nastran", write, read, weight=3),) if importlib.util.find_spec("pyyeti") else ()
