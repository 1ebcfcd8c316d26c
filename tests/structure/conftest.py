"""The structure of three modes, and the folder of others' models."""

import numpy as np
import pytest

from mechid.structure import Modes
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT


@pytest.fixture
def modes():
    return Modes(FREQUENCY_HZ, DAMPING, INTERFACE, LINE_OF_SIGHT)


@pytest.fixture(scope="session")
def craig_bampton_folder(data_folder):
    """Return the folder of published Craig-Bampton models, outside the repository."""
    with np.printoptions():  # importing pyYeti changes how NumPy prints
        pytest.importorskip("pyyeti.nastran")
    return data_folder / "craig_bampton" / "cla_test_data_2020"
