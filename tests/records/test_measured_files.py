"""Measured data by others: every file of the formats opens with the right arrays or is refused with the reason."""

import numpy as np
import pytest
import scipy.io

from mechid.errors import RecordError
from mechid.records import ChannelSpec, Conditioning, RecordSpec, TimeStamps, open_table, read_record

pytestmark = pytest.mark.data


def table(folder, name):
    return open_table(folder / name, name)


def column(opened, key):
    return next(index for index, found in enumerate(opened.columns) if found.key == key)


def values(opened, key):
    return opened.read([column(opened, key)])[0]


def read(folder, name, *channels, **asked):
    return read_record(folder / name, RecordSpec(name="run", path=name, channels=channels, **asked))


UFF = "formats/uff/"


def test_the_same_record_in_ascii_and_binary_58_agrees(data_folder, figure):
    """Published: n = 79 292, dx = 1.526e-5 s; ASCII has six digits after the point."""
    ascii_, binary = (table(data_folder, UFF + name) for name in ("Sample_UFF58_ascii.uff", "Sample_UFF58b_bin.uff"))
    (one,), (two,) = ascii_.read([0]), binary.read([0])
    assert one.size == two.size == 79292
    np.testing.assert_allclose(one, two, rtol=6e-6, atol=1e-7)
    for opened in (ascii_, binary):
        assert opened.columns[0].unit == "Pa"
        interval = 1.0 / opened.columns[0].clock.rate_hz
        figure("UFF 58: sample interval", interval, least=1.525875e-5, most=1.525885e-5, unit="s")


def test_a_sine_of_double_precision_in_58b_is_one(data_folder):
    opened = table(data_folder, UFF + "binary8byte.uff")
    np.testing.assert_allclose(opened.read([0])[0], np.sin(2 * np.pi * 5.0 * np.arange(250) / 100.0), atol=1e-5)
    assert opened.columns[0].clock.rate_hz == 100.0


def test_a_last_line_that_is_not_full_is_read(data_folder):
    opened = table(data_folder, UFF + "time-history-not-all-columns-filled.uff")
    assert opened.columns[0].samples == 13
    np.testing.assert_allclose(opened.read([0])[0][:3], [-3.81956, -3.56616, -2.98987])
    assert opened.columns[0].unit == "m/s²"


REFUSED_COLUMNS = {
    UFF + "dataset_milestone_in_header.uff": "it holds 42 of the 2508876 samples that its head promises",
    UFF + "non_ascii_header.uff": "it is no time history but a frequency response function",
    UFF + "sample_dataset58_psd.uff": "it is no time history but a power spectral density",
}
REFUSED_FILES = {
    UFF + "1858.uff": "no data set 58 (measured functions); its data sets: 1858, 1858",
    UFF + "TestLab 161 164 18 15 82.uff": "data sets: 151, 164, 18, 15, 82, 82, 82",
    UFF + "heat_engine_housing.uff": "data sets: 151, 164, 2411, 2412, 2414",
    "cogging/cogging_tableau.txt": "columns in the header",
}


@pytest.mark.parametrize("name", REFUSED_COLUMNS)
def test_a_data_set_that_is_no_whole_time_history_is_refused(data_folder, name):
    with pytest.raises(RecordError, match=REFUSED_COLUMNS[name]):
        table(data_folder, name).read([0])


@pytest.mark.parametrize("name", REFUSED_FILES)
def test_a_file_without_records_is_refused_with_the_reason(data_folder, name):
    with pytest.raises(RecordError) as caught:
        table(data_folder, name)
    assert REFUSED_FILES[name] in str(caught.value)


TDMS = {
    "raw1": ("Layer Data/Seventh Cha", 2000, 50000.0, "Volts"),
    "big_endian": ("Measured Data/Phase sweep", 3500, 1000.0, None),
    "raw_timestamps": ("Untitled/Untitled", 128, 1000.0, None),
    "Digital_Input": (
        "07/09/2012 06:58:23 PM - Digital Input - All Data/Dev1_port3_line7 - line 0",
        20000,
        2000.0,
        None,
    ),
}


@pytest.mark.parametrize("name", TDMS)
def test_tdms_is_read_as_by_its_own_library_at_once(data_folder, name):
    """Twin: npTDMS reading the whole file."""
    from nptdms import TdmsFile

    key, samples, rate, unit = TDMS[name]
    path = data_folder / "formats" / "tdms" / f"{name}.tdms"
    opened = open_table(path, path.name)
    index = column(opened, key)
    group, _, channel = key.rpartition("/")
    with path.open("rb") as file:
        expected = TdmsFile.read(file)[group][channel][:]
    np.testing.assert_array_equal(opened.read([index])[0], expected)
    assert (opened.columns[index].samples, opened.columns[index].clock.rate_hz) == (samples, rate)
    assert opened.columns[index].unit == unit


def test_a_sine_of_128_samples_from_tdms_is_one(data_folder):
    sine = values(table(data_folder, "formats/tdms/raw_timestamps.tdms"), "Untitled/Untitled")
    np.testing.assert_allclose(sine, np.sin(2.0 * np.pi * np.arange(128) / 128.0), atol=1e-12)


def test_daqmx_volts_are_a_voltage(data_folder):
    asked = ChannelSpec(quantity="voltage_phase_a", column="Third Chan")
    record = read(data_folder, "formats/tdms/raw1.tdms", asked)
    assert record.channel("voltage_phase_a").data[0] == pytest.approx(1.73528245, abs=1e-8)
    assert record.start_time == "2016-12-15T22:35:21.000000"


def test_what_mat73_holds_beside_numbers_is_told(data_folder):
    opened = table(data_folder, "formats/mat73/testfile1.mat")
    assert opened.metadata["data/arr_char"] == "test"
    faults = {found.key: found.fault for found in opened.columns if found.fault}
    assert 'an object of the MATLAB class "missing" without a readable array of numbers' in faults["data/missing_"]
    assert "sparse" in faults["data/sparse_"]
    with pytest.raises(RecordError, match="no array of numbers is found; in MATLAB save plain arrays"):
        values(opened, "data/missing_")


@pytest.mark.parametrize("name", ["testfile1", "testfile2", "testfile3", "testfile5", "testfile12"])
def test_mat73_gives_the_arrays_that_h5py_has(data_folder, name):
    """Twin: h5py, following the references by hand."""
    import h5py

    path = data_folder / "formats" / "mat73" / f"{name}.mat"
    opened = open_table(path, path.name)
    assert opened.columns
    with h5py.File(path) as file:
        for index, found in enumerate(opened.columns):
            if found.fault:
                assert any(word in found.fault for word in ("complex", "sparse", "matrix", "MATLAB class"))
                continue
            node = file
            numbers = []
            for part in found.key.split("/"):
                if isinstance(node, h5py.Group):
                    node = node[part]
                elif node.dtype == h5py.ref_dtype:
                    node = file[node[()].ravel(order="F")[int(part)]]
                else:
                    numbers.append(int(part))
            expected = np.squeeze(node[()])
            if numbers:
                expected = expected[numbers[0]] if expected.shape[1] > expected.shape[0] else expected[:, numbers[0]]
            np.testing.assert_array_equal(opened.read([index])[0], expected)


def test_emps_is_read_with_its_gains(data_folder):
    """Published: 24 841 samples at 1 kHz, force = 35.15065 N/V x vir."""
    force = ChannelSpec(quantity="force", column="vir", unit="N", gain=35.15065188248547)
    position = ChannelSpec(quantity="position", column="qm", unit="m")
    record = read(data_folder, "EMPS/DATA_EMPS.mat", force, position)
    twin = scipy.io.loadmat(data_folder / "EMPS" / "DATA_EMPS.mat")
    assert (record.samples, record.sample_rate_hz) == (24841, 1000.0)
    assert record.metadata["gtau"] == pytest.approx(35.15065, abs=1e-5)
    np.testing.assert_array_equal(record.channel("position").data, twin["qm"].ravel())
    np.testing.assert_allclose(record.channel("force").data, twin["gtau"][0, 0] * twin["vir"].ravel(), rtol=1e-14)


def test_the_robots_structs_and_its_object_are_taken_apart(data_folder):
    name = "gear_robot/A_data.mat"
    axis = ChannelSpec(quantity="rotor_angle", column="rec/act_pos_mot_deg/0", unit="deg")
    torque = ChannelSpec(quantity="torque", column="rec/act_torque_abs_nm/0")
    time = ChannelSpec(quantity="time", column="rec/time_cont")
    record = read(data_folder, name, torque, axis, time=time)
    twin = scipy.io.loadmat(data_folder / name)["rec"][0, 0]
    assert (record.samples, record.sample_rate_hz, record.duration_s) == (2501, 250.0, 10.0)
    np.testing.assert_allclose(record.channel("rotor_angle").data, np.deg2rad(twin["act_pos_mot_deg"][0]), rtol=1e-14)
    np.testing.assert_array_equal(values(table(data_folder, name), "KR300/gravity"), [0.0, 0.0, 9.81])
    with pytest.raises(RecordError, match="2 columns may be the time"):
        read(data_folder, name, torque)


def test_the_steppers_runs_are_read_beside_an_object(data_folder):
    rate = ChannelSpec(quantity="rotor_rate", column="valo1000")
    record = read(data_folder, "stepper_encoder/constant_rates_fullstep.mat", rate)
    assert (record.samples, record.sample_rate_hz) == (10001, 1000.0)


def test_a_simulink_dataset_is_read(data_folder):
    """Truth: the same file's plain time, and its range: Simulink R2024b saved seven signals, six of them each ms."""
    name = "stepper_encoder/constant_rates_fullstep.mat"
    opened = table(data_folder, name)
    signals = [c for c in opened.columns if c.key.startswith("out/logsout/")]
    assert {c.name for c in signals} >= {"pps", "wcs2", "wcs2_raw_volt", "Lowpass Filter"}
    assert {(c.samples, c.clock.rate_hz, c.clock.start_s) for c in signals} == {(10001, 1000.0, 0.0)}
    np.testing.assert_allclose(values(opened, "out/tout"), values(opened, "t"), atol=1e-12)
    volts = values(opened, "out/logsout/wcs2_raw_volt")
    assert volts[0] == 0.0
    assert 2.0 < volts[5000] < volts.max() < 2.07
    record = read(data_folder, name, ChannelSpec(quantity="voltage", column="wcs2_raw_volt"))
    assert (record.samples, record.sample_rate_hz) == (10001, 1000.0)


def test_the_steppers_counts_are_read(data_folder):
    opened = table(data_folder, "stepper_encoder/single_steps_10pps.npz")
    assert opened.metadata == {"fs": 1000.0, "cpr": 8192, "pps": 10}
    counts = values(opened, "counts_fullstep")
    twin = np.load(data_folder / "stepper_encoder" / "single_steps_10pps.npz")
    np.testing.assert_array_equal(counts, twin["counts_fullstep"])


@pytest.mark.parametrize("name", ["toes_ffns", "toeco_ffns"])
def test_simulated_forcing_functions_are_read(data_folder, name):
    path = f"craig_bampton/cla_test_data_2020/{name}.mat"
    twin = scipy.io.loadmat(data_folder / path)
    opened = table(data_folder, path)
    for row, expected in enumerate(twin["ffns"]):
        np.testing.assert_array_equal(values(opened, f"ffns/{row}"), expected)
    assert opened.metadata["sr"] == 500.0


TORQUE = ChannelSpec(quantity="torque", column="torque")


def test_the_pendulums_irregular_clock_is_refused_and_conditioned(data_folder):
    name = "pendulum/data_measured.csv"
    with pytest.raises(RecordError, match="irregular time"):
        read(data_folder, name, TORQUE)
    record = read(data_folder, name, TORQUE, conditioning=Conditioning(time_stamps=TimeStamps.REGULAR))
    raw = np.loadtxt(data_folder / name, delimiter=",", skiprows=1)
    assert record.samples == len(raw)
    assert record.sample_rate_hz == pytest.approx(1.0 / np.mean(np.diff(raw[:, 0])), rel=1e-4)
    np.testing.assert_array_equal(record.channel("torque").data, raw[:, 3])


@pytest.mark.parametrize("name", ["rolling_data", "rolling_data1", "rolling_data2", "acc_current"])
def test_cogging_runs_are_interpolated_over_their_jitter(data_folder, name):
    """Truth: the stamps are multiples of 0.1 ms, mostly 1 ms apart; a sample on the new clock is the old one."""
    asked = ChannelSpec(quantity="current_phase_a", column="Iq", unit="A")
    how = Conditioning(time_stamps=TimeStamps.RESAMPLE, max_gap_s=0.1)
    record = read(data_folder, f"cogging/{name}.txt", asked, conditioning=how)
    raw = np.loadtxt(data_folder / "cogging" / f"{name}.txt", delimiter=",", skiprows=1)
    assert record.sample_rate_hz == 1000.0
    assert record.duration_s == pytest.approx(raw[-1, 0] - raw[0, 0], abs=1e-3)
    places = (raw[:, 0] - raw[0, 0]) * 1000.0
    exact = np.abs(places - np.rint(places)) < 1e-6
    found = record.channel("current_phase_a").data[np.rint(places[exact]).astype(int)]
    assert np.count_nonzero(exact) > 0.1 * len(raw)
    np.testing.assert_allclose(found, raw[exact, 3], atol=1e-9)
    assert record.treatments[0]["step"] == "time_stamps"


def test_a_drives_export_with_its_own_head_is_read(data_folder):
    """Truth: its head says an interval of 1000 us."""
    name = next((data_folder / "torque_ripple" / "PI-QLR-SDM251").glob("*.dcexp")).relative_to(data_folder)
    record = read(data_folder, str(name), ChannelSpec(quantity="rotor_rate", column=1))
    assert (record.samples, record.sample_rate_hz) == (30288, 1000.0)
    assert record.channel("rotor_rate").data[0] == pytest.approx(83.12 * 2.0 * np.pi / 60.0)
    assert record.metadata["line 4"] == "Interval (us)\t1000"


def test_the_accelerometers_line_of_125_hz_is_there(data_folder, figure):
    """Published: a line of 125 Hz, every 32 steps of 250 us, 0.04 g in amplitude (one digit); 16384 counts per g."""
    asked = ChannelSpec(quantity="force", column=1, unit="N", gain=1.0 / 16384.0)  # no quantity of acceleration
    record = read(data_folder, "stepper_accel/goniometer/250usec_slew.txt", asked, sample_rate_hz=4000.0)
    data = record.channel("force").data
    spectrum = np.abs(np.fft.rfft(data - data.mean())) * 2.0 / data.size
    line = int(np.argmax(spectrum))
    figure("stepper's accelerometer: largest line", line * 4000.0 / data.size, least=123.7, most=126.3, unit="Hz")
    amplitude = np.sqrt(np.sum(spectrum[line - 4 : line + 5] ** 2))
    figure("stepper's accelerometer: amplitude of the line", amplitude, least=0.035, most=0.045, unit="g")
