"""The start of a record in the campaign file. Truth: sizes by hand, and the rate commanded where the file begins."""

import numpy as np
import pytest

from csv_files import write_csv
from layouts import mechanism_of, paper_table
from mechid.campaign import load_campaign, mechanism_text
from mechid.errors import InputFileError
from mechid.identification.output_error.target import target_of

STEPS = 'stepping = "full", rate = 46.0, start_angle_deg = 45.0'
TORQUE_DRIVE = {
    "assembly": "direct_torque_drive",
    "load": {"inertia": 1e-3},
    "drive": {},
    "friction": {"static": 0.01, "coulomb": 0.005, "viscous": 1e-3},
}


def campaign(folder, command, *more, first_s=0.0, table=None, samples=200):
    """Write and read a campaign of one record, whose file begins at some time."""
    (folder / "mechanism.toml").write_text(mechanism_text(mechanism_of(table or paper_table())))
    t = first_s + np.arange(samples) / 1e4
    write_csv(folder / "run.csv", "time_s,torque_Nm,other", t, np.sin(300 * t), np.cos(100 * t), fmt="%.12g")
    lines = [
        'mechanism = "mechanism.toml"',
        "[[record]]",
        'name = "run"',
        'file = "run.csv"',
        f"command = {{ {command} }}",
    ]
    (folder / "campaign.toml").write_text("\n".join([*lines, *more]) + "\n")
    return load_campaign(folder)


def own(record):
    return {q.name.rpartition(".")[2]: q for q in record.start}


def test_all_states_are_free_about_rest_where_the_record_begins_with_its_command(tmp_path):
    """Truth by hand: a full step is 1.8 deg; the motor held by one phase turns with k_m U/R, its current is U/R."""
    (record,) = campaign(tmp_path, f'{STEPS}, start = "estimated"').records
    states = own(record)
    assert set(states) == {"angle", "rate", "twist", "twist_rate", "current_a", "current_b", "housing", "housing_rate"}
    assert all(q.is_free and q.value == 0.0 and q.sigma == pytest.approx(q.max / 3.0) for q in states.values())
    m = mechanism_of(paper_table())
    U, R, k_m = (m.value(f"stepper.{name}") for name in ("peak_voltage", "coil_resistance", "torque_constant"))
    assert states["angle"].max == pytest.approx(1.5 * np.radians(1.8))
    assert states["current_a"].max == pytest.approx(1.5 * U / R)
    assert states["twist"].min == pytest.approx(-1.5 * 50.0 * k_m * U / R / m.value("gear.stiffness"))
    assert record.command.begun_s == 0.0


def test_a_file_that_begins_later_begins_in_motion_at_the_commanded_rate(tmp_path):
    made = campaign(tmp_path, f'{STEPS}, start = "estimated"', first_s=2.5)
    (record,) = made.records
    assert record.command.begun_s == pytest.approx(2.5)
    rate = own(record)["rate"]
    assert rate.value == pytest.approx(46.0 * np.radians(1.8))
    assert 0.5 * (rate.min + rate.max) == pytest.approx(rate.value)
    assert made.warnings == ()


def test_the_earliest_instant_that_a_free_time_offset_allows_is_where_it_begins(tmp_path):
    offset = "time_offset_s = { value = 0.0, min = -0.01, max = 0.02 }"
    (record,) = campaign(tmp_path, f'{STEPS}, start = "estimated"', offset, first_s=2.5).records
    assert record.command.begun_s == pytest.approx(2.48)


def test_states_that_the_file_names_are_as_it_says(tmp_path):
    given = "start_state = { rate = { value = 1.0, min = -2.0, max = 3.0 }, current_a = 0.1 }"
    states = own(campaign(tmp_path, f'{STEPS}, start = "estimated"', given).records[0])
    assert (states["rate"].value, states["rate"].min, states["rate"].max, states["rate"].sigma) == (
        1.0,
        -2.0,
        3.0,
        None,
    )
    assert states["current_a"].value == 0.1
    assert not states["current_a"].is_free
    assert states["angle"].is_free


@pytest.mark.parametrize(
    ("command", "more", "message"),
    [
        (
            STEPS,
            "start_state = { rate = 1.0 }",
            'start_state: there is no estimated start; write start = "estimated" in command',
        ),
        (f'{STEPS}, start = "estimated"', "start_state = 3", "start_state: found 3; write a table"),
        (f'{STEPS}, start = "estimated"', "start_state = { rates = 1.0 }", "start_state.rates: unknown key"),
        (STEPS, "burn_in_s = -0.1", "burn_in_s: found -0.1; write a time of 0 s or more"),
        (STEPS, "burn_in_s = 0.02", "burn_in_s: found 0.02, but the record lasts 0.0199 s"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(tmp_path, command, more, message):
    with pytest.raises(InputFileError) as error:
        campaign(tmp_path, command, more)
    assert f"campaign.toml: record[0].{message}" in str(error.value)


def test_a_drive_that_tells_no_size_wants_bounds(tmp_path):
    channels = """channels = [{ quantity = "output_angle", column = 1, unit = "rad" },
                  { quantity = "torque", column = 2, unit = "N m", role = "input" }]"""
    with pytest.raises(InputFileError, match="nothing says how far the start may be off; give the states"):
        campaign(tmp_path, 'start = "estimated"', channels, table=TORQUE_DRIVE)
    given = "start_state = { rate = { value = 0.0, min = -1.0, max = 1.0 } }"
    (record,) = campaign(tmp_path, 'start = "estimated"', channels, given, table=TORQUE_DRIVE).records
    states = own(record)
    assert [key for key, q in states.items() if q.is_free] == ["rate"]
    assert states["angle"].value == 0.0


def test_a_burn_in_does_not_count(tmp_path):
    (record,) = campaign(tmp_path, STEPS, "burn_in_s = 0.005").records
    target = target_of(record)
    assert target.burn_in == 50
    np.testing.assert_array_equal(target.leading.rejected, np.arange(50))
