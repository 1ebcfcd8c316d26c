"""Frequency responses of universal files. Truth: the modes that they were sampled from."""

import numpy as np
import pytest

from mechid.structure import Location, Selection, read_structure


def test_responses_of_a_universal_file(tmp_path):
    """Truth: what was written; of directions to which one line of sight has no response none is there."""
    pyuff = pytest.importorskip("pyuff")
    rng, grid = np.random.default_rng(0), np.linspace(1.0, 20.0, 20)
    sets = {
        (3, 6): rng.normal(size=(2, 2, 20)),
        (3, 1): rng.normal(size=(2, 2, 20)),
        (3, 2): rng.normal(size=(1, 2, 20)),
    }
    path = tmp_path / "frf.uff"
    for (node, direction), data in sets.items():
        for response, (re, im) in zip((4, 5), data, strict=False):
            unit = "N*m" if direction > 3 else "N"
            pyuff.UFF(str(path)).write_sets(
                pyuff.prepare_58(
                    binary=0,
                    func_type=4,
                    rsp_node=9,
                    rsp_dir=response,
                    ref_node=node,
                    ref_dir=direction,
                    x=grid,
                    data=re + 1j * im,
                    id1="made up",
                    rsp_ent_name="structure",
                    ref_ent_name="structure",
                    abscissa_spacing=1,
                    abscissa_spec_data_type=18,
                    ordinate_spec_data_type=8,
                    orddenom_spec_data_type=13,
                    ordinate_axis_units_lab="rad",
                    orddenom_axis_units_lab=unit,
                ),
                "add" if path.exists() else "overwrite",
            )
    lines = {"x": (Location(9, "rx"),), "y": (Location(9, "ry"),)}
    structure = read_structure(path, Selection(interface=Location(3, "rz"), line_of_sight=lines))
    assert set(structure.directions) == {"tx"}
    wanted = (sets[3, 1][:, 0] + 1j * sets[3, 1][:, 1]).T
    np.testing.assert_allclose(structure.along("tx", grid), wanted, rtol=1e-6)
