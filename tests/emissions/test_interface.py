"""Loads at the interface. Truth: statics, and loads through a table of one mode by hand."""

import numpy as np
import pytest

import mechid
from emission_bench import CHANNELS, background, record, requirement, samples, write_campaign
from loads_by_hand import record_of
from mechid.campaign.bench_entry import Bench
from mechid.campaign.place import Place
from mechid.campaign.table_response_entry import DIRECTIONS, DeclaredResponse, TableMode
from mechid.emissions.interface import Interface
from mechid.errors import InputFileError, RecordError
from mechid.records import Mounting
from mechid.records.calibration import Calibration
from mechid.records.components import COMPONENTS

FS = 4000.0
TIME = np.arange(8000) / FS
PLACE = Place("campaign.toml", "bench")
POINT = (0.02, -0.03, 0.06)
F0 = 900.0


def bench(modes=(F0,) * 6, **more):
    response = DeclaredResponse(
        place=PLACE.key("table_response"),
        file=None,
        modes=tuple(TableMode(component=k, frequency_hz=f, damping=0.02, share=1.0) for k, f in enumerate(modes)),
        uncertainty=0.003,
        damping_uncertainty=0.2,
    )
    return Bench(place=PLACE, mounting=Mounting("z", (0.0, 0.0, 0.0)), response=response if modes else None, **more)


def sines(amplitudes, f=400.0):
    return np.array([a * np.cos(2.0 * np.pi * f * TIME + k) for k, a in enumerate(amplitudes)])


def channels(loads):
    return {"torque" if name == "moment_z" else name: y for name, y in zip(COMPONENTS, loads, strict=True)}


def test_volts_through_a_table_become_loads_about_the_interface_point():
    """Truth: M_O = M_P + r x F, then 1 / (1 - r^2) by the table, then the inverse of the calibration."""
    at_interface = sines((1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    about_table = at_interface.copy()
    about_table[3:] += np.cross(POINT, at_interface[:3], axisb=0).T
    h = 1.0 / (1.0 - (400.0 / F0) ** 2 + 0.04j * 400.0 / F0)
    # turning all sines by one angle is a delay
    delayed = np.abs(h) * (about_table * np.cos(np.angle(h)) - quadrature(about_table) * np.sin(np.angle(h)))
    to_volts = np.diag([0.1, 0.1, 0.05, 2.0, 2.0, 4.0])
    calibration = Calibration(matrix=np.linalg.inv(to_volts), in_volts=True, uncertainty=0.003, source="c")
    made = Interface(bench(calibration=calibration, interface_point_m=POINT))
    found = made.load(record_of(channels(to_volts @ delayed), FS))
    for name, wanted in channels(at_interface).items():
        assert np.abs(found.channel(name).data - wanted)[200:-200].max() < 0.003 * max(np.abs(wanted).max(), 0.3)
    assert [one["step"] for one in found.treatments] == ["calibrated", "table", "moved"]


def quadrature(y):
    """Return sines a quarter of a turn ahead of cosines of 400 Hz, which have whole periods in the record."""
    spectrum = np.fft.rfft(y)
    return np.fft.irfft(-1j * spectrum, y.shape[1])


def test_the_band_of_a_moved_moment_is_that_of_all_loads_it_is_made_of():
    made = Interface(bench(modes=(500.0, 900.0, 900.0, 900.0, 900.0, 1200.0), interface_point_m=(0.0, 0.05, 0.0)))
    # M_z takes F_x by the arm y
    assert made.band_hz("mz") == made.band_hz("fx")
    assert made.band_hz("my")[1] > 1.5 * made.band_hz("fx")[1]


def test_the_error_of_a_load_comes_from_all_loads():
    """Truth: 1 % of the calibration, of a moment of 0.1 m for each newton."""
    calibration = Calibration(matrix=np.eye(6), in_volts=False, uncertainty=0.01, source="c")
    made = Interface(bench(modes=(), calibration=calibration))
    densities = {name: np.zeros(3) for name in DIRECTIONS} | {"fx": np.ones(3), "mz": np.full(3, 4.0)}
    found = made.error_density("mz", np.array([10.0, 20.0, 30.0]), densities)
    assert found == pytest.approx([1e-4 * (0.1**2 * 1.0 + 4.0)] * 3)


def test_a_moved_moment_has_the_error_of_its_forces():
    calibration = Calibration(matrix=np.eye(6), in_volts=False, uncertainty=0.01, source="c")
    made = Interface(bench(modes=(), calibration=calibration, interface_point_m=(0.0, 0.5, 0.0)))
    densities = {name: np.zeros(1) for name in DIRECTIONS} | {"fx": np.ones(1)}
    # at the table, F_x and a moment of -0.5 m times it, whose errors are 0.01 (1 + 0.5 / 0.1) and 0.01 (0.1 + 0.5)
    force, moment = 1e-4 * (1.0 + (0.5 / 0.1) ** 2), 1e-4 * (0.1**2 + 0.5**2)
    assert made.error_density("mz", np.array([10.0]), densities)[0] == pytest.approx(0.25 * force + moment)


def test_a_prediction_is_about_the_mounting_point():
    assert not list(Interface(bench(interface_point_m=(0.0, 0.0, 0.0))).prediction_notes())
    assert "about mounting_point_m" in next(Interface(bench(interface_point_m=POINT)).prediction_notes())


def test_without_a_bench_a_record_stays_as_it_is():
    raw = record_of({"torque": TIME})
    made = Interface(Bench(place=PLACE))
    assert made.load(raw) is raw
    assert not made.is_uncertain


FULL = Calibration(matrix=np.ones((6, 6)) + np.eye(6), in_volts=False, uncertainty=0.0, source="c")


@pytest.mark.parametrize(
    ("more", "lacking", "message"),
    [
        ({"interface_point_m": POINT}, "force_x", "about the interface point takes force_x"),
        ({"calibration": FULL}, "force_y", "has no force_y, which the calibration"),
    ],
)
def test_a_background_without_a_component_is_refused(more, lacking, message):
    own = {name: y for name, y in channels(sines((1.0,) * 6)).items() if name != lacking}
    with pytest.raises(RecordError, match=message):
        Interface(bench(**more)).load(record_of(own, FS))


MODES = "[" + ", ".join(f'{{ direction = "{d}", frequency_hz = 300.0, damping = 0.02 }}' for d in DIRECTIONS) + "]"
LINES = ((46.0, 0.05), (150.0, 0.02))


def campaign(folder, declared, *wanted):
    """Write a run whose sines went through modes of 300 Hz and a background."""
    passed = [(f, a / (1.0 - (f / 300.0) ** 2)) for f, a in LINES]
    runs = {"run": samples(1, passed), "off": samples(2)}
    write_campaign(folder, runs, record("run", 46.0), background(), *wanted)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text.replace("[0.0, 0.0, 0.0]\n", f"[0.0, 0.0, 0.0]\n{declared}\n", 1))
    return folder


def test_a_corrected_line_decides(tmp_path):
    """Truth: 0.02 N at half of the table's mode, which reads a third more."""
    wanted = requirement(mask=((100.0, 0.0225), (190.0, 0.0225)))
    as_recorded = mechid.emission(campaign(tmp_path, "", wanted))
    assert as_recorded.assessments[0].verdict == "fail"
    declared = f"table_response = {{ modes = {MODES}, uncertainty_percent = 1.0 }}"
    found = mechid.emission(campaign(tmp_path, declared, wanted))
    assert found.assessments[0].verdict == "pass"
    worst = found.assessments[0].judged.worst
    assert worst.value == pytest.approx(0.02, rel=0.02)
    # 2 r^2 / (1 - r^2) of 1 % at half of the mode
    assert worst.upper - worst.value > 1.96 * 0.02 * 0.0066
    assert found.bench.response == "6 modes"
    assert found.usable_hz[1] == pytest.approx(261.0, abs=4.0)


def test_a_declared_band_is_all_that_is_judged(tmp_path):
    found = mechid.emission(campaign(tmp_path, "usable_band_hz = [20.0, 120.0]", requirement()))
    assert found.assessments[0].judged_hz == (20.0, 120.0)
    assert found.usable_hz == (20.0, 120.0)
    assert any(
        "not judged is its mask at 120 to 500 Hz, outside the band of records and bench" in n for n in found.notes
    )


def test_channels_in_volts(tmp_path):
    """Truth: 20 N/V of a line of 0.05 N."""
    matrix = [[20.0 if i == k else 0.0 for k in range(6)] for i in range(6)]
    units = 'input_unit = "V", output_unit = ["N", "N*m"], uncertainty_percent = 0.3'
    runs = {"run": samples(1, LINES) / 20.0, "off": samples(2) / 20.0}
    volts = CHANNELS.replace('"N"', '"V"').replace('"N*m"', '"V"')
    folder = write_campaign(tmp_path, runs, record("run", 46.0).replace(CHANNELS, volts), background(), requirement())
    text = (folder / "campaign.toml").read_text()
    declared = f"[0.0, 0.0, 0.0]\ncalibration = {{ matrix = {matrix}, {units} }}\n"
    (folder / "campaign.toml").write_text(text.replace("[0.0, 0.0, 0.0]\n", declared, 1))
    found = mechid.emission(folder)
    line = next(one for one in found.lines if one.direction == "fx" and one.order == 1.0)
    assert line.amplitude == pytest.approx(0.05, abs=4.0 * line.sigma)
    (folder / "campaign.toml").write_text(text)
    with pytest.raises(InputFileError, match=r'record\[0\].channels\[0\].unit: unit "V" does not measure force_x'):
        mechid.emission(folder)


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (f"table_response = {{ modes = {MODES}, uncertainty_percent = 1.0 }}\nusable_band_hz = [1.0, 2.0]\n", None),
        (
            f"calibration = {{ matrix = {np.eye(6).tolist()}, "
            'input_unit = ["N", "N*m"], output_unit = ["N", "N*m"], uncertainty_percent = 10.0 }',
            "calibration.uncertainty_percent: with 10 % the loads are uncertain by more than 1 dB at all",
        ),
        ('table_response = { file = "t.csv", uncertainty_percent = 1.0 }\nusable_band_hz = [5.0, 400.0]',
         "table_response: covers 20 to 300 Hz, but usable_band_hz is 5 to 400 Hz"),
        ('table_response = { file = "t.csv", uncertainty_percent = 9.0 }', "supports no frequency in fx"),
        ('table_response = { file = "fy.csv", uncertainty_percent = 1.0 }',
         r"requirement\[0\].direction: table_response has no response of fx"),
    ],
)  # fmt: skip
def test_a_bench_that_supports_nothing_is_refused(tmp_path, declared, message):
    f = np.linspace(20.0, 300.0, 141)
    for name, axis in (("t", "fx"), ("fy", "fy")):
        header = f"frequency_Hz,{axis}_re [1],{axis}_im [1]"
        rows = np.column_stack([f, np.ones(f.size), np.zeros(f.size)])
        np.savetxt(
            tmp_path / f"{name}.csv",
            rows,
            delimiter=",",
            header=header,
            comments="",
        )
    folder = campaign(tmp_path, declared, requirement())
    if message is None:
        assert mechid.emission(folder).assessments[0].verdict == "not_decidable"
        return
    with pytest.raises(InputFileError, match=message):
        mechid.emission(folder)
