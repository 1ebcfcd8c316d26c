"""What is odd about a record and yet usable. Truth: the oddity that was put into the file; the record is named."""

import numpy as np
import pytest

from mechid.campaign import load_campaign
from mechid.errors import InputFileError, RecordError

FULL = 'record "full_46": '
SWEEP = 'record "sweep": '


def test_more_than_one_step_between_two_samples(changed):
    """Truth: at 2500 full steps/s and 1 kHz, at most three edges 0.4 ms apart fit into 1 ms."""
    path = changed("campaign.toml", "rate = 46.0", "rate = 2500.0")
    warning = f"{FULL}up to 3 steps fall between two samples; they are simulated exactly, check the rate, "
    warning += "and whether the time is in ms or the sample rate in kHz"
    assert load_campaign(path).warnings == (warning,)


@pytest.mark.parametrize(("angle", "warned"), [("0.7854", True), ("-1.570796", True), ("0.75", False), ("45.0", False)])
def test_a_start_angle_in_radians_is_asked_about(changed, angle, warned):
    """Truth: 0.7854 and -1.570796 are pi/4 and -pi/2."""
    path = changed("campaign.toml", "start_angle_deg = 45.0", f"start_angle_deg = {angle}")
    assert any("is this in rad?" in line for line in load_campaign(path).warnings) == warned


@pytest.mark.parametrize(("end", "warned"), [("1.0", False), ("1.0014", False), ("1.01", True)])
def test_a_record_shorter_than_its_command(changed, end, warned):
    """Truth: the record has samples from 0 s to 1 s; one sample interval is forgiven."""
    path = changed("campaign.toml", "[1.0, 20.0]", f"[{end}, 20.0]")
    warning = f"{SWEEP}the record ends at 1 s of a command that goes on to 1.01 s; is it whole?"
    assert load_campaign(path).warnings == ((warning,) if warned else ())


def test_a_text_cut_anywhere_is_refused_or_told_by_its_commands_duration(folder, write_record):
    """Truth: the whole file. Cut within a line it is refused or its end is warned of, at a line end it is too short."""
    whole = write_record()
    ends = [k + 1 for k, letter in enumerate(whole) if letter == "\n"]
    rng = np.random.default_rng(4)
    refusals = 0
    for end in [*rng.integers(0, len(whole) - 2, 50), *rng.choice(ends[20:-2], 50)]:
        (folder / "sweep.csv").write_text(whole[:end])
        try:
            warnings = load_campaign(folder).warnings
        except RecordError as error:
            refusals += 1
            assert str(error).startswith("sweep.csv: ")  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert any("is it whole?" in line or "is the file cut off there?" in line for line in warnings), end
    assert 0 < refusals < 50


def test_a_command_delayed_beyond_the_record(changed):
    path = changed("campaign.toml", "{ value = 0.0, min = -0.002, max = 0.002 }", "2.0")
    assert load_campaign(path).warnings == (f"{SWEEP}the record ends before its command starts; check time_offset_s",)


def test_a_recorder_with_a_clock_of_its_own(folder, write_record):
    (folder / "full_46.csv").write_text(write_record(start_s=3600.0))
    assert load_campaign(folder).warnings == (
        f"{FULL}the command starts 3600 s before the first sample; if they start together, write time_offset_s = 3600",
    )


def test_a_time_offset_answers_it(folder, changed, write_record):
    (folder / "full_46.csv").write_text(write_record(start_s=3600.0))
    changed("campaign.toml", 'file = "full_46.csv"', 'file = "full_46.csv"\ntime_offset_s = 3600.0')
    assert load_campaign(folder).warnings == ()


def test_two_records_of_one_file(changed):
    path = changed("campaign.toml", '"sweep.csv"', '"full_46.csv"')
    warning = f'{SWEEP}full_46.csv is the same file as that of "full_46"; is that meant?'
    assert load_campaign(path).warnings == (warning,)


def test_what_the_reader_found_odd(folder):
    rows = [f"{k / 1000:.3f},{min(max((k % 100 - 50) / 25, -1.0), 1.0)}" for k in range(1001)]
    (folder / "full_46.csv").write_text("\n".join(["time_s,torque_Nm", *rows]))
    (warning,) = load_campaign(folder).warnings
    assert warning.startswith(f"{FULL}full_46.csv: line ")
    assert "clipped" in warning


def test_a_channel_that_is_not_used(changed):
    channels = '[{ quantity = "torque", column = 1 }, { quantity = "force", column = 0, unit = "N" }]'
    path = changed("campaign.toml", 'file = "full_46.csv"', f'file = "full_46.csv"\nchannels = {channels}')
    campaign = load_campaign(path, read_records=False)
    assert campaign.warnings == (f"{FULL}force: not used, the mechanism does not give it",)


def test_a_frequency_in_hertz(changed, folder):
    changed("mechanism.toml", "{ value = 5000.0, min = 2500.0, max = 9000.0 }", "888.0")
    assert load_campaign(folder).warnings == (
        "mechanism.toml: housing.frequency = 888: is this in Hz? it is read in rad/s",
    )


def with_noise(changed, sigma):
    """Return the campaign with a noise level declared for the torque of its first record."""
    channels = f'channels = [{{ quantity = "torque", column = "torque_Nm", noise_sigma = {sigma} }}]'
    return changed("campaign.toml", 'file = "full_46.csv"', f'file = "full_46.csv"\n{channels}')


@pytest.mark.parametrize("sigma", ["5e-324", "1e-12"])
def test_a_noise_level_of_nothing_is_told(changed, sigma):
    (said,) = load_campaign(with_noise(changed, sigma)).warnings
    assert said.startswith(f"{FULL}noise_sigma of torque: found {float(sigma):.4g}, where the channel's own standard")
    assert said.endswith("a millionth of that is used")


@pytest.mark.parametrize("sigma", ["1e9", "1.7e308"])
def test_a_noise_level_that_leaves_nothing_to_be_told_is_refused(changed, sigma):
    with pytest.raises(InputFileError, match=r"channels\[0\]\.noise_sigma: found .* any motion fits"):
        load_campaign(with_noise(changed, sigma))


@pytest.mark.parametrize("sigma", ["1e-5", "10.0"])
def test_any_other_noise_level_is_the_users(changed, sigma):
    assert load_campaign(with_noise(changed, sigma)).warnings == ()


MOTOR = """assembly = "brushed_dc_drive"

[motor]
resistance = { value = 1.5, min = 0.5, max = 5.0 }
inductance = 2e-3
torque_constant = 0.05
inertia = 1e-4

[friction]
coulomb = 0.01
viscous = 1e-5
"""


@pytest.mark.parametrize(
    ("volts", "own", "warned"),
    [
        ("constant", "", True),
        ("pulses", "", True),
        ("to and fro", "", False),
        ("constant", ", offset = false", False),
        ("constant", ", offset = true", False),
    ],
)
def test_a_mean_that_is_taken_for_an_offset_is_asked_about(tmp_path, volts, own, warned):
    """Truth: the mean current of a motor at a constant voltage is what its resistance and friction make it."""
    t = np.arange(500) / 1000.0
    u = {"constant": np.full(t.size, 6.0), "pulses": 12.0 * (t % 0.02 < 0.01), "to and fro": np.sin(60.0 * t)}[volts]
    y = np.random.default_rng(0).normal(0.3, 0.01, (2, t.size))
    np.savetxt(tmp_path / "run.csv", np.stack([t, u, *y], axis=1), "%.6g", ",", header="t,u,i,w", comments="")
    (tmp_path / "mechanism.toml").write_text(MOTOR)
    (tmp_path / "campaign.toml").write_text(
        f"""mechanism = "mechanism.toml"

[[record]]
name = "run"
file = "run.csv"
time = {{ column = "t", unit = "s" }}
channels = [
  {{ quantity = "voltage", column = "u", unit = "V", role = "input" }},
  {{ quantity = "current", column = "i", unit = "A"{own} }},
  {{ quantity = "rotor_rate", column = "w", unit = "rad/s" }},
]
"""
    )
    said = [line for line in load_campaign(tmp_path).warnings if "projected out" in line]
    assert len(said) == warned
    for line in said:
        assert line.startswith('record "run": current: ')
        assert "write offset = false in its channel" in line
