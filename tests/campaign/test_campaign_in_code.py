"""Mechanisms, commands and records without files. Truth: the arrays given, and what the same in files gives."""

import numpy as np
import pandas as pd
import pytest

import mechid
from mechid.campaign import mechanism_text
from samples_in_memory import COMMAND, RATE_HZ, SOURCES, TIME, TORQUE

DRIVE = {
    "assembly": "direct_torque_drive",
    "load": {"inertia": {"value": 0.1, "min": 0.01, "max": 1.0}},
    "friction": {"static": 0.02, "coulomb": 0.02, "viscous": 0.001},
}


def data_of(*records):
    return mechid.make_campaign(mechid.catalogue_mechanism(), records).records


@pytest.mark.parametrize("source", SOURCES)
def test_samples_are_the_same_whatever_holds_them(source):
    (record,) = data_of(SOURCES[source]())
    assert record.data.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-9)
    assert record.data.time_start_s == 0.0
    assert np.allclose(record.data.channel("torque").data[:], TORQUE, rtol=0.0, atol=1e-12)
    assert record.file is None


def test_records_may_come_one_after_another_or_alone():
    """Truth: the same record in a list."""
    for records in (SOURCES["list"](), iter([SOURCES["list"]()])):
        (record,) = mechid.make_campaign(mechid.catalogue_mechanism(), records).records
        assert np.array_equal(record.data.channel("torque").data[:], TORQUE)


def test_samples_in_memory_are_those_of_a_file(tmp_path):
    rows = "\n".join(f"{t!r},{y!r}" for t, y in zip(TIME.tolist(), TORQUE.tolist(), strict=True))
    (tmp_path / "a.csv").write_text(f"time_s,torque_Nm\n{rows}\n")
    (tmp_path / "mechanism.toml").write_text(mechanism_text(mechid.catalogue_mechanism()))
    (tmp_path / "campaign.toml").write_text(
        'mechanism = "mechanism.toml"\n[[record]]\nname = "a"\nfile = "a.csv"\n'
        'command = { stepping = "full", rate = 46.0 }\ntime_offset_s = { value = 0.0, min = -0.001, max = 0.001 }\n'
    )
    read = mechid.load_campaign(tmp_path)
    entries = {"time_offset_s": {"value": 0.0, "min": -0.001, "max": np.float64(0.001)}}
    made = mechid.make_campaign(
        mechid.catalogue_mechanism(), [mechid.make_record("a", TORQUE, time_s=TIME, command=COMMAND, entries=entries)]
    )
    assert made.parameters == read.parameters
    assert made.records[0].command == read.records[0].command
    assert np.array_equal(made.records[0].data.channels[0].data[:], read.records[0].data.channels[0].data[:])
    assert made.warnings == read.warnings == ()


def test_what_goes_out_comes_in_again():
    (record,) = data_of(SOURCES["array and rate"]())
    for out in (record.data.to_pandas(), record.data.to_xarray()):
        (again,) = data_of(mechid.make_record("a", out, command=COMMAND))
        assert np.array_equal(again.data.channel("torque").data[:], TORQUE)


def test_a_measured_channel_drives_a_mechanism():
    force = 0.3 * np.sign(np.sin(2.0 * np.pi * 5.0 * TIME))
    channels = [
        {"quantity": "torque", "column": "torque", "role": "input", "between": "held"},
        {"quantity": "output_rate", "column": "output_rate"},
    ]
    made = mechid.make_campaign(
        mechid.make_mechanism(DRIVE),
        [mechid.make_record("a", {"torque": force, "output_rate": TIME}, sample_rate_hz=RATE_HZ, channels=channels)],
    )
    rate = mechid.simulate(made).values["output_rate"]
    late = slice(20, 90)  # within the first half period, in motion
    expected = (0.3 - 0.02 - 0.001 * rate[late]) / 0.1  # J dw/dt = T - T_c - b w
    assert np.gradient(rate, TIME)[late] == pytest.approx(expected, rel=1e-3)


def test_another_mechanism_file_may_be_named_as_text(tmp_path):
    made = mechid.make_campaign(mechid.catalogue_mechanism(), [mechid.make_record("a", command=COMMAND)])
    mechid.write_campaign(made, tmp_path)
    mechid.write_mechanism(mechid.catalogue_mechanism().with_values({"gear.stiffness": 900.0}), tmp_path / "other.toml")
    read = mechid.load_campaign(str(tmp_path), need_files=False, mechanism_file=str(tmp_path / "other.toml"))
    assert read.mechanism.value("gear.stiffness") == 900.0
    assert read.mechanism_path == tmp_path / "other.toml"


def test_stages_and_options_of_a_campaign_are_given_as_the_file_has_them():
    stage = {"records": ["a"], "window_s": (0.0, 0.2), "free": ["gear.stiffness"]}
    made = mechid.make_campaign(
        mechid.catalogue_mechanism(),
        [SOURCES["array and rate"]()],
        entries={"stage": [stage], "identify": {"colour": "none"}},
    )
    assert made.stages == (mechid.Stage(records=("a",), window_s=(0.0, 0.2), free=("gear.stiffness",)),)
    assert made.options == mechid.IdentifyOptions(colour="none")


REFUSED = {
    "two dimensions": (lambda: mechid.make_record("a", np.zeros((20, 2)), command=COMMAND), "found 20 x 2"),
    "an argument among entries": (lambda: mechid.make_record("a", TORQUE, entries={"use": "validate"}), "argument of"),
    "two clocks": (lambda: mechid.make_record("a", TORQUE, time_s=TIME, sample_rate_hz=1.0), "keep one of them"),
    "no clock": (lambda: data_of(mechid.make_record("a", TORQUE, command=COMMAND)), "no time column"),
    "not finite": (
        lambda: data_of(mechid.make_record("a", np.where(TIME > 0.1, np.nan, 0.0), time_s=TIME, command=COMMAND)),
        "a: ",
    ),
    "masked": (
        lambda: data_of(
            mechid.make_record("a", np.ma.masked_less(TORQUE, -0.9), sample_rate_hz=RATE_HZ, command=COMMAND)
        ),
        "a: sample 15: .* is not a finite number",
    ),
    "dates": (
        lambda: data_of(
            mechid.make_record("a", np.arange(400).astype("M8[ms]"), sample_rate_hz=RATE_HZ, command=COMMAND)
        ),
        "it holds dates, no measured numbers",
    ),
    "times and another rate": (
        lambda: data_of(
            mechid.make_record("a", {"time_s": TIME, "torque": TORQUE}, sample_rate_hz=200.0, command=COMMAND)
        ),
        "sample_rate_hz = 200 contradicts the time column",
    ),
    "times of another name and another rate": (
        lambda: data_of(mechid.make_record("a", {"t": TIME, "torque": TORQUE}, sample_rate_hz=200.0, command=COMMAND)),
        "sample_rate_hz = 200 contradicts the time column",
    ),
    "an index and another rate": (
        lambda: data_of(mechid.make_record("a", pd.Series(TORQUE, index=TIME), sample_rate_hz=200.0, command=COMMAND)),
        "sample_rate_hz = 200 contradicts the time column",
    ),
    "times that go back": (
        lambda: data_of(mechid.make_record("a", pd.Series(TORQUE, index=TIME)[::-1], command=COMMAND)),
        "the clock goes back",
    ),
    "a path for the mechanism": (lambda: mechid.make_campaign("mechanism.toml", []), "mechanism: found str"),
    "a mapping of records": (
        lambda: mechid.make_campaign(mechid.catalogue_mechanism(), {"a": SOURCES["list"]()}),
        "records: found str",
    ),
    "another quantity's unit": (
        lambda: data_of(mechid.make_record("a", {"torque [V]": TORQUE}, sample_rate_hz=1.0, command=COMMAND)),
        "torque",
    ),
    "no command": (
        lambda: data_of(mechid.make_record("a", TORQUE, sample_rate_hz=1.0)),
        "record\\[0\\].command: missing",
    ),
    "a wrong key": (
        lambda: data_of(mechid.make_record("a", command=COMMAND, entries={"ofset": True})),
        'did you mean "offset"',
    ),
    "the same name": (
        lambda: data_of(mechid.make_record("a", command=COMMAND), mechid.make_record("a", command=COMMAND)),
        "is also the name",
    ),
    "a key of the whole": (
        lambda: mechid.make_campaign(mechid.catalogue_mechanism(), [], entries={"mechanism": "m.toml"}),
        "unknown key",
    ),
    "a mechanism's key": (
        lambda: mechid.make_mechanism({**DRIVE, "load": {"inertai": 0.1}}, name="drive"),
        "drive: load.inertai",
    ),
    "stepping": (lambda: mechid.make_command("quarter", rate=46.0), "stepping: found"),
    "an assembly": (lambda: mechid.catalogue_mechanism("two_mass"), 'did you mean "two_mass_drive"'),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused_with_its_place(case):
    make, message = REFUSED[case]
    with pytest.raises(mechid.MechidError, match=message):
        make()
