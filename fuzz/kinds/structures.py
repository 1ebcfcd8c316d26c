"""Files of structures: tables and responses as CSV, MATLAB files, universal files."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.records_read import damaged
from fuzz.kinds.tomls import finite
from fuzz.trial import Kind, Misread

GRID = np.arange(1.0, 40.0, 0.5)


def _modes(draw: Draw) -> dict[str, np.ndarray]:
    """Return frequencies, dampings and shapes of some modes, at times with a number at an edge."""
    count = draw.choice((1, 2, 3, 3, 5))
    found = {
        "frequency_hz": np.sort(np.array([draw.uniform(0.0, 90.0) for _ in range(count)])),
        "damping": np.array([draw.uniform(0.001, 0.05) for _ in range(count)]),
        "interface": np.array([draw.uniform(-0.3, 0.3) for _ in range(count)]),
        "los_x": np.array([draw.uniform(-0.3, 0.3) for _ in range(count)]),
    }
    if draw.chance(0.4):
        found[draw.choice(list(found))][draw.randrange(count)] = draw.number()
    return found


def _responses(draw: Draw) -> np.ndarray:
    """Return receptances (n, 2): interface and line of sight, of a structure of two modes."""
    w, total = 2.0 * np.pi * GRID, np.zeros((GRID.size, 2), dtype=complex)
    for f, a, b in ((3.0, 0.1, 0.05), (18.0, 0.2, -0.12)):
        w_k = 2.0 * np.pi * f
        total += np.outer(a / (w_k**2 - w**2 + 0.02j * w_k * w), [a, b])
    if draw.chance(0.4):
        total[draw.randrange(GRID.size), draw.randrange(2)] = draw.number()
    return total


def write_csv(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a table of modes or of responses."""
    path = folder / "s.csv"
    separator = draw.choice((",", ",", ";", "\t"))
    modes: dict[str, list[float]] = {}
    if draw.chance(0.5):
        table = _modes(draw)
        modes = {key: value.tolist() for key, value in table.items()}
        names = ["frequency_Hz", *list(table)[1:]]
    else:
        h = _responses(draw)
        table = {"f": GRID, "a": h[:, 0].real, "b": h[:, 0].imag, "c": h[:, 1].real, "d": h[:, 1].imag}
        unit = draw.choice(("", " [urad/(N*m)]", " [rad/s^2/(N*m)]", f" [{draw.text()}]"))
        ends = draw.choice((("_re", "_im"), ("_mag", "_phase_deg")))
        names = [
            "frequency_Hz",
            *(f"{who}{end}{unit if end in ('_re', '_mag') else ''}" for who in ("interface", "x") for end in ends),
        ]
    is_changed = draw.chance(0.3)
    if is_changed:
        names[draw.randrange(len(names))] = draw.text()
    rows = [separator.join(repr(float(x)) for x in row) for row in zip(*table.values(), strict=True)]
    path.write_bytes("\n".join([separator.join(names), *rows, ""]).encode("utf-8", "replace"))
    done = {"file": path.name, "modes": {} if is_changed else modes, "damaged": False}
    return damaged(draw, path, done)


def write_mat(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write modes, responses or a state space; one variable may be anything."""
    from scipy.io import savemat

    modes, kind = {}, draw.randrange(3)
    content: dict[str, Any]
    if kind == 0:
        found = _modes(draw)
        modes = {key: value.tolist() for key, value in found.items()}
        content = {**found, "line_of_sight": found["los_x"][None, :]}
        content.pop("los_x")
    elif kind == 1:
        h = _responses(draw)
        content = {
            "frequency_hz": GRID,
            "interface": h[:, 0],
            "line_of_sight": h[:, 1:],
            "unit": draw.choice(("rad/(N*m)", draw.text() or "x")),
        }
    else:
        w = draw.uniform(1.0, 100.0)
        content = {
            "A": np.array([[0.0, 1.0], [-(w**2), -0.1]]),
            "B": np.array([[0.0], [1.0]]),
            "C": np.array([[1.0, 0.0], [0.5, 0.0]]),
        }
    if draw.chance(0.3):
        content["line_of_sight_names"] = np.array(["los"], dtype=object)
    if draw.chance(0.5):
        modes = {}
        odd = (
            "text",
            1.0,
            np.zeros((2, 3, 2)),
            np.zeros(0),
            np.array([1j]),
            {"a": 1.0},
            np.array([1, "b"], dtype=object),
            True,
            np.full((2, 2), np.nan),
            np.zeros((1, 40)),
            np.int8(3),
            np.full((1, 3), 1e308),
        )
        key = draw.choice(list(content))
        content[key] = draw.choice(odd)
        if draw.chance(0.2):
            del content[key]
    savemat(folder / "s.mat", content, do_compression=draw.chance(0.3))
    return damaged(draw, folder / "s.mat", {"file": "s.mat", "modes": modes, "damaged": False})


def write_uff(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write responses to the torque at node 3, with fields changed."""
    import pyuff

    path, h = folder / draw.choice(("s.uff", "s.unv")), _responses(draw)
    sets = []
    for node, direction, data in ((3, 6, h[:, 0]), (1, 4, h[:, 1]), (1, 5, h[:, 1])):
        given: dict[str, Any] = {
            "binary": draw.choice((0, 0, 1)),
            "func_type": 4,
            "rsp_node": node,
            "rsp_dir": direction,
            "ref_node": 3,
            "ref_dir": 6,
            "data": data,
            "x": GRID,
            "id1": "made up",
            "rsp_ent_name": "s",
            "ref_ent_name": "s",
            "abscissa_spacing": 1,
            "abscissa_spec_data_type": 18,
            "ordinate_spec_data_type": 8,
            "orddenom_spec_data_type": 13,
            "ordinate_axis_units_lab": draw.choice(("rad", "NONE", "urad")),
            "orddenom_axis_units_lab": draw.choice(("N*m", "NONE")),
        }
        if draw.chance(0.3):
            key = draw.choice(
                ("func_type", "rsp_node", "rsp_dir", "ref_dir", "ordinate_spec_data_type", "ordinate_axis_units_lab")
            )
            given[key] = (
                draw.text()[:20].replace("\0", "")
                if isinstance(given[key], str)
                else draw.choice((0, 1, -6, 99, 11, 12))
            )
        if draw.chance(0.1):
            given["x"], given["data"] = GRID[:-3], data[:-3]
        sets.append(pyuff.prepare_58(**given))
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
    return damaged(draw, path, {"file": path.name, "modes": {}, "damaged": False}, 0.25)


def read(folder: Path, written: dict[str, Any]) -> None:
    """Read the structure, compare its modes, ask for its responses."""
    from mechid.structure import Location, Selection, read_structure

    is_universal = written["file"].endswith(("uff", "unv"))
    lines = {"x": (Location(1, "rx"), Location(1, "ry", 0.5))}
    selection = Selection(interface=Location(3, "rz"), line_of_sight=lines) if is_universal else Selection()
    structure = read_structure(folder / written["file"], selection)
    finite(structure)
    if written["damaged"]:
        return
    for key, attribute in (("frequency_hz", "frequency_hz"), ("interface", "interface"), ("damping", "damping")):
        if key in written["modes"]:
            found = np.asarray(getattr(structure.model, attribute))
            if not np.array_equal(found, np.array(written["modes"][key])):
                raise Misread(f"mode {key}: {found} where {written['modes'][key]} was written")


STRUCTURES = (
    Kind("structure_csv", write_csv, read, weight=3),
    Kind("structure_mat", write_mat, read, weight=3),
    Kind("structure_uff", write_uff, read, weight=2),
)
