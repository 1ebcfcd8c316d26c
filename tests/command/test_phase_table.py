"""A driver's table in a command. Truth: the cosine's own values, rows typed by hand, and the equations of the drive."""

import numpy as np
import pytest

import mechid
import paper
from mechid.campaign.campaign_writer import command_text
from mechid.command import Command, RateProfile
from mechid.command.phase_table import nominal_table, phase_table_text, read_phase_table
from mechid.command.words import command_words
from mechid.errors import InputFileError, UsageError
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

N = 8
ODD = tuple((0.01 * k, 0.5 - 0.02 * k) for k in range(4 * N))
RATE = RateProfile.through([(0.0, 40.0), (0.1, 40.0), (0.1, -40.0)])


def command(**own):
    return Command(**{"stepping": "micro", "microsteps": N, "rate": RATE, **own})


@pytest.mark.parametrize("angle", [0.0, 45.0, -101.25])
def test_the_nominal_table_is_the_cosine(angle):
    table, cosine = (
        command(table=tuple(map(tuple, nominal_table(N).tolist())), start_angle_deg=angle),
        command(start_angle_deg=angle),
    )
    np.testing.assert_array_equal(table.excitation(0.2).times, cosine.excitation(0.2).times)
    np.testing.assert_allclose(table.excitation(0.2).values, cosine.excitation(0.2).values, atol=4e-16)
    np.testing.assert_allclose(table.excitation(0.2).initial, cosine.excitation(0.2).initial, atol=4e-16)


def test_rows_follow_the_steps_from_the_start_angle_both_ways():
    """Truth: 90 deg are a full step, 8 rows; 32 steps forward in 0.1 s, then back."""
    found = command(table=ODD, start_angle_deg=90.0)
    assert tuple(found.excitation(0.2).initial) == ODD[8]
    rows = [8 + k for k in range(1, 33)] + [8 + k for k in range(31, -1, -1)]
    np.testing.assert_array_equal(found.excitation(0.2).values, [ODD[row % 32] for row in rows])
    later = found.begin_at(0.1)
    assert tuple(later.excitation(0.1).initial) == ODD[8]


def test_the_kernel_is_driven_by_it():
    """Truth: half of every value is half the peak voltage."""
    mechanism = paper.mechanism()
    half = tuple((0.5 * a, 0.5 * b) for a, b in nominal_table(N).tolist())
    values = {"stepper.peak_voltage": 0.5 * mechanism.value("stepper.peak_voltage")}
    base = TimeBase(1e4, 1500)
    by_table = simulate_run(Simulator(mechanism.plant, command(table=half), base).run(mechanism.kernel_values()))
    weaker = mechanism.with_values(values)
    by_volts = simulate_run(Simulator(weaker.plant, command(), base).run(weaker.kernel_values()))
    np.testing.assert_allclose(by_table.torque, by_volts.torque, rtol=0.0, atol=1e-12)
    assert np.ptp(by_volts.torque) > 1e-2


def test_it_is_read_from_a_file_and_written_in_a_campaign(tmp_path):
    (tmp_path / "table.csv").write_text(phase_table_text(ODD))
    entries = {"stepping": "micro", "microsteps": N, "rate": 40.0, "table": "table.csv"}
    found = Command.from_table(entries, "campaign.toml: record[0].command", tmp_path)
    assert found.table == ODD
    assert "table = [[0.0, 0.5], [0.01, 0.48]" in command_text(found)
    assert mechid.make_command("micro", microsteps=N, rate=40.0, table=np.array(ODD)) == found
    assert mechid.make_command("micro", microsteps=N, rate=40.0, table=tmp_path / "table.csv") == found
    assert command_words(found).endswith("from 0 deg, by a table of 32 values")


WRONG = {
    "rows": ({"table": ODD[:-1]}, "table: found 31 rows; 8 microsteps a full step need 32, an electrical period"),
    "codes": ({"table": [[127, 0]] * 32}, "table: row 0: found [127, 0]; write [phase_a, phase_b]"),
    "stepping": ({"stepping": "full", "microsteps": 1, "table": ODD}, "table: found with full stepping"),
    "waveform": ({"table": ODD, "waveform": "square"}, 'table: found beside waveform = "square"'),
    "between rows": ({"table": ODD, "start_angle_deg": 5.0}, "start_angle_deg: found 5; a table has values at"),
    "number": ({"table": 3}, "table: found 3; write the name of a file"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_table_is_refused(case):
    own, said = WRONG[case]
    with pytest.raises(UsageError) as refused:
        Command.from_entries({"stepping": "micro", "microsteps": N, "rate": 40.0, **own})
    assert str(refused.value).startswith(said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "header: found an empty file"),
        ("a,b\n1,2\n", 'header: found "a,b"; write "microstep,phase_a,phase_b"'),
        ("microstep,phase_a,phase_b\n0,0,1\n2,0,1\n", 'line 3: found "2,0,1"; write 1, then both phases'),
        ("microstep,phase_a,phase_b\n0,zero,1\n", 'line 2: found "0,zero,1"; write 0, then both phases'),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path, text, said):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(InputFileError) as refused:
        read_phase_table(path)
    assert str(refused.value).startswith(f"{path}: {said}")
    with pytest.raises(UsageError, match="table: "):
        command().from_entries({"stepping": "micro", "microsteps": N, "rate": 1.0, "table": "table.csv"}, tmp_path)
