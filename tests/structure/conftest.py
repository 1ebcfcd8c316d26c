"""The structure of three modes, and the folder of others' models."""

import numpy as np
import pytest

from mechid.structure import Modes
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT, TILT, TRANSLATION


@pytest.fixture
def modes():
    return Modes(FREQUENCY_HZ, DAMPING, INTERFACE, LINE_OF_SIGHT)


@pytest.fixture
def toml(tmp_path):
    """Return a modal table with two directions beside the mechanism's own."""
    lines = ['line_of_sight = ["x", "y"]', 'axis = "rz"']
    for k, (f, zeta) in enumerate(zip(FREQUENCY_HZ, DAMPING, strict=True)):
        lines += [
            "[[mode]]",
            f"frequency_hz = {f}",
            f"damping = {zeta}",
            f"interface = {INTERFACE[k]}",
            f"line_of_sight = {LINE_OF_SIGHT[:, k].tolist()}",
            f"directions = {{ tx = {TRANSLATION[k]}, ry = {TILT[k]} }}",
        ]
    path = tmp_path / "modes.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def craig_bampton_folder(data_folder):
    """Return the folder of published Craig-Bampton models, outside the repository."""
    with np.printoptions():  # importing pyYeti changes how NumPy prints
        pytest.importorskip("pyyeti.nastran")
    return data_folder / "craig_bampton" / "cla_test_data_2020"
