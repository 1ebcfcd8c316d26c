"""Levels of the line of sight. Truth: the budget's own response of the structure to the same motion."""

import numpy as np
import pytest

import mechid
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.quiet_drives.table_command import table_command
from mechid.structure import Structure

STRUCTURE_TOML = """
axis = "rz"
line_of_sight = ["x", "y"]
[[mode]]
frequency_hz = 35.0
damping = 0.02
interface = 0.2
line_of_sight = [0.05, 0.02]
"""
DESIGN = {
    "rates": [30.0],
    "orders": [1.0],
    "range": {"from": 29.0, "to": 32.0},
    "microsteps": 4,
    "steppings": ["micro"],
    "axis": "rz",
    "structure": {"file": "structure.toml"},
}


@pytest.fixture(scope="module")
def seen(fit, tmp_path_factory):
    folder = tmp_path_factory.mktemp("line_of_sight")
    (folder / "structure.toml").write_text(STRUCTURE_TOML)
    design = {**DESIGN, "structure": {"file": str(folder / "structure.toml")}, "limit": {"rms_rad": 1e-3}}
    return mechid.quiet(fit, design)


def test_torque_has_no_weight_of_its_own():
    np.testing.assert_array_equal(TORQUE.weight(np.array([1.0, 30.0])), [1.0, 1.0])
    assert TORQUE.unit == "N*m"


class KnownTo100Hz:
    """Response of 1 rad/(N m) of one line of sight up to 100 Hz."""

    def response(self, frequency_hz):
        return np.where(frequency_hz[:, None] <= 100.0, np.ones((1, 2), dtype=complex), np.nan)


def test_frequencies_that_the_structure_does_not_cover_count_as_nothing_and_are_told():
    quantity = Quantity(Structure(name="s", line_of_sight=("x",), model=KnownTo100Hz()))
    frequency, lines = np.array([50.0, 500.0]), np.array([3.0 + 0j, 4.0 + 0j])
    np.testing.assert_array_equal(quantity.weight(frequency), [1.0, 0.0])
    assert quantity.uncovered_share(frequency, lines) == pytest.approx(0.8)


@pytest.mark.slow
def test_the_level_is_that_of_a_budget(seen, fit):
    estimate, rate = flying_estimate(fit, Flight()), 30.0
    mode = OperatingMode(
        name="table", command=table_command(seen.table, rate), rates=np.array([rate]), highest_hz=2000.0
    )
    substeps = enough_substeps(estimate.mechanism, mode, estimate.names)
    state = steady_state(estimate.mechanism, mode, rate, estimate.names, substeps)
    rms = respond(state, seen.design.quantity.structure).rms()
    assert rms.size == 2
    assert seen.improvement.gains[0].after == pytest.approx(np.sqrt(np.sum(rms**2)), rel=1e-2)


@pytest.mark.slow
def test_the_line_of_sight_falls_and_files_and_page_say_so(seen, tmp_path):
    assert seen.improvement.gains[0].gain_db > 6.0
    seen.write(tmp_path)
    assert (tmp_path / "rates.csv").read_text().startswith("stepping,rate,rms_rad,bound_rad,verdict\nmicro4,29")
    assert "RMS line of sight down by" in str(seen)
    page = (tmp_path / "quiet.html").read_text()
    assert "Lines of sight x, y, their root sum of squares," in page
    assert "RMS before, rad" in page
