"""Two finished fits, written by hand and compared."""

import pytest

import mechid
from estimates import BOTH, ONE, write


@pytest.fixture
def pair(tmp_path):
    """Return a function that writes and compares two fits, A with two free parameters, B with one."""

    def make(a, b, *, parameters=(BOTH, ONE), outcomes=("converged", "converged")):
        folders = [
            write(tmp_path / name, records, own, outcome)
            for name, records, own, outcome in zip("AB", (a, b), parameters, outcomes, strict=True)
        ]
        return mechid.compare(*folders)

    return make
