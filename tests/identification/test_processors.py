"""Fits of models that lack nothing by kernels for several processors; truth: one another, to a tenth of a sigma."""

import pytest

from processors import PROCESSORS, differences, fits


@pytest.mark.slow
@pytest.mark.parametrize("name", ["family_1_seed_0", "two_mass_drive", "current_driven_stepper", "direct_force_drive"])
def test_a_complete_fit_is_the_same_on_every_processor(name, tmp_path):
    told = list(differences(fits(name, tmp_path)))
    assert not told, "\n".join(told)


def entry(value, status="free", std_error=0.2):
    q = {"value": value, "std_error": std_error, "unit": "deg", "status": status}
    return {"outcome": "converged", "parameters": {"phase_deg": q}}


@pytest.mark.parametrize(
    ("there", "told"),
    [(entry(179.99), 0), (entry(-180.01), 0), (entry(179.9), 1), (entry(180.0, "at_bound", None), 1)],
)
def test_a_fit_that_another_processor_finds_otherwise_is_told(there, told):
    """Truth: a tenth of a standard error of 0.2 deg; phases are compared on the circle."""
    found = {**dict.fromkeys(PROCESSORS, entry(180.0)), "generic": there}
    assert len(list(differences(found))) == told
