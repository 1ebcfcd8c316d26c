"""What flies of an estimate. Truth: what its file and the budget file say."""

import numpy as np
import pytest

from mechid.budgets.flight_entry import Flight, LoadMode
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.errors import InputFileError
from mechid.identification.result.fit_file import read_fit
from paper_estimate import write_estimate_of_paper


def test_the_test_stand_stays_behind(flying):
    assert list(flying.left) == ["[housing]"]
    assert "housing.gain" not in flying.names
    assert not any(name.startswith("housing") for name in flying.mechanism.parameters)
    assert flying.mechanism.value("stepper.back_emf_constant") == flying.mechanism.value("stepper.torque_constant")


def test_what_flies_replaces_what_was_estimated(tmp_path):
    """Truth: the file. A value that is given is no longer uncertain."""
    flight = Flight(values={"gear.stiffness": 1000.0, "load.inertia": 0.02}, load_modes=(LoadMode(5.0, 0.01, 0.01),))
    flying = flying_estimate(read_fit(write_estimate_of_paper(tmp_path)), flight)
    assert flying.mechanism.value("gear.stiffness") == 1000.0
    assert "gear.stiffness" not in flying.names
    assert flying.mechanism.value("load.mode.0.inertia") == 0.01
    assert flying.mechanism.value("load.mode.0.frequency") == pytest.approx(2.0 * np.pi * 5.0)
    with pytest.raises(InputFileError, match=r'did you mean "gear[.]stiffness"'):
        flying_estimate(read_fit(tmp_path / "estimate.json"), Flight(spread={"gear.stifness": 1.0}))
    with pytest.raises(InputFileError, match=r"is not above the modes' 0[.]5"):
        flying_estimate(read_fit(tmp_path / "estimate.json"), Flight(load_modes=(LoadMode(5.0, 0.01, 0.5),)))


def test_what_is_uncertain_joins_the_covariance(tmp_path):
    """Truth: the file. What is estimated already is refused."""
    path = write_estimate_of_paper(tmp_path)
    flying = flying_estimate(read_fit(path), Flight(uncertain={"stepper.peak_voltage": 0.05, "load.inertia": 1e-4}))
    assert flying.names[-2:] == ("stepper.peak_voltage", "load.inertia")
    np.testing.assert_allclose(np.diag(flying.covariance)[-2:], [0.05**2, 1e-8])
    with pytest.raises(InputFileError, match=r"gear[.]stiffness is estimated and has its error from there"):
        flying_estimate(read_fit(path), Flight(uncertain={"gear.stiffness": 1.0}))
    moved = Flight(values={"gear.stiffness": 900.0}, uncertain={"gear.stiffness": 9.0})
    assert flying_estimate(read_fit(path), moved).names[-1] == "gear.stiffness"
