"""A driver whose microstep table is off. Truth: its phase voltages typed by hand, fed in as measured channels."""

import numpy as np
import pytest

from layouts import LAYOUTS, paper_with
from mechid.command import Command, InputChannel, MeasuredCommand, RateProfile
from mechid.errors import InputFileError
from paper import constant
from runs import base, rms, run_kernel, run_twin

TABLE = LAYOUTS["microstep table"]
RIGID = {"housing": None}
OWN = ("c_m1", "s_m1", "c_m2", "s_m2")


def by_hand(time_base, microsteps):
    """Return both voltages of the paper's command of 50 steps/s, the table's angle in place of the one commanded."""
    theta = np.pi / 4 + np.pi / 2 * np.floor(time_base.times * 50.0 * microsteps + 1e-9) / microsteps
    off = 0.03 * np.sin(2 * theta + np.radians(40.0)) + 0.05 * np.sin(4 * theta - np.radians(25.0))
    turned, longer = theta + np.arctan(off), np.hypot(1.0, off)
    return -5.7 * longer * np.cos(turned), 5.7 * longer * np.sin(turned)


@pytest.mark.slow
@pytest.mark.parametrize("microsteps", [1, 4])
def test_a_table_turns_what_is_commanded(microsteps):
    time_base = base(0.1)
    channels = tuple(
        InputChannel(quantity=f"voltage_phase_{x}", held=True, samples=u)
        for x, u in zip("ab", by_hand(time_base, microsteps), strict=True)
    )
    command = MeasuredCommand(start_angle_deg=45.0).driven_by(channels, 10_000.0, 0.0)
    measured = paper_with({**RIGID, "stepper": {"drive": "measured_voltage", "peak_voltage": None}})
    expected = run_kernel(measured, command, time_base).torque
    torque = run_kernel(paper_with({**RIGID, **TABLE}), constant(50.0, microsteps=microsteps), time_base).torque
    assert rms(torque - expected) <= 1e-5 * rms(expected)


@pytest.mark.slow
def test_a_square_wave_comes_from_no_table():
    """Truth: the same mechanism without the table, both phases fully on in every full step."""
    square = Command(
        stepping="full", microsteps=1, rate=RateProfile.constant(50.0), start_angle_deg=45.0, waveform="square"
    )
    with_table, without = (run_kernel(paper_with({**RIGID, **t}), square, base(0.05)).torque for t in (TABLE, {}))
    np.testing.assert_allclose(with_table, without, rtol=0, atol=1e-9 * np.abs(without).max())


def test_its_parts_have_their_derivatives():
    """Truth: the twin's variational equations, and central differences; at the null too."""
    nothing = [{"order": h["order"], "amplitude": 0.0} for h in TABLE["stepper"]["microstep_table"]]
    for m in (paper_with({**RIGID, **TABLE}), paper_with({**RIGID, "stepper": {"microstep_table": nothing}})):
        command, time_base = constant(46.0, microsteps=4), base(0.06)
        chosen = [list(map(str, m.plant.parameters)).index(name) for name in OWN]
        kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=8).jacobian["torque"]
        twin = run_twin(m, command, time_base, sensitive=chosen).jacobian[:, 0]
        assert np.all(np.linalg.norm(kernel - twin, axis=0) <= 1e-5 * np.linalg.norm(twin, axis=0))
        p = m.kernel_values()
        for j, i in enumerate(chosen):
            step = 1e-6 * np.eye(p.size)[i]
            up, down = (run_kernel(m, command, time_base, p=p + way * step, substeps=8).torque for way in (1, -1))
            off = np.abs((up - down) / 2e-6 - kernel[:, j]) > 1e-4 * np.abs(kernel[:, j]).max()
            assert off.sum() <= 5, m.plant.parameters[i]


REFUSED = {
    "measured voltages": (
        {"stepper": {"drive": "measured_voltage", "peak_voltage": None, **TABLE["stepper"]}},
        "measured channels drive the phases, the driver's table in them; delete it",
    ),
    "an order that is too high": (
        {"stepper": {"microstep_table": [{"order": 32, "amplitude": 0.01}]}},
        "stepper.microstep_table.0.order: ",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_driver_has_is_refused(case):
    changes, message = REFUSED[case]
    with pytest.raises(InputFileError, match=r"^mechanism.toml: stepper\.microstep_table") as caught:
        paper_with(changes)
    assert message in str(caught.value)
