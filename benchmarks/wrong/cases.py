"""The table of wrong campaigns: what is wrong, in how many ways, and which words name it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from wrong.bench import HEADER, RATE_HZ, RUNS, Files, as_measured, clean_torque, csv_text, measured_torque, time_of

FloatArray = NDArray[np.float64]
BARE = {"sample_rate_hz": "10000.0", "channels": '[{ quantity = "torque", column = "torque_Nm" }]'}


@dataclass(frozen=True)
class Case:
    """One wrong campaign.

    Attributes
    ----------
    kind : str
        A row of the table.
    name : str
        Of the variant, and of its folder.
    words : str
        A pattern; a line that has it names the cause.
    make : callable
        Makes right files wrong.
    """

    kind: str
    name: str
    words: str
    make: Callable[[Files], None]


def cases() -> tuple[Case, ...]:
    """Return all wrong campaigns."""
    return (*_signs_and_times(), *_drives(), *_rows_and_clocks(), *_units(), *_files(), *_chains(), *_mechanisms())


def _signs_and_times() -> Iterator[Case]:
    sign = "(other sign|polarity|direction)"
    yield Case("polarity", "sign_one", f"full_46.*{sign}", partial(_changed, names=("full_46",), by=np.negative))
    yield Case("polarity", "sign_all", f"all records.*{sign}", partial(_changed, names=RUNS, by=np.negative))
    yield Case("polarity", "rate_sign_one", f"micro_46.*{sign}", partial(_commanded, name="micro_46", rate="-46.0"))
    late = r"(time.offset|\blate\b|trigger)"  # a misfit oscillates
    yield Case("trigger", "late_5ms_one", f"full_46.*{late}", partial(_late, names=("full_46",), seconds=5e-3))
    yield Case("trigger", "late_50ms_one", f"full_46.*{late}", partial(_late, names=("full_46",), seconds=50e-3))
    yield Case("trigger", "late_5ms_all", f"(all records|full_46).*{late}", partial(_late, names=RUNS, seconds=5e-3))
    yield Case("trigger", "begun_30ms_one", f"full_46.*({late}|motion)", partial(_begun, name="full_46", seconds=0.03))


def _drives() -> Iterator[Case]:
    rate = "(rate|clock|steps/s)"
    yield Case("rate", "rate_1pc_full", f"full_46.*{rate}", partial(_commanded, name="full_46", rate="46.46"))
    profile = f"[[0.0, 0.0], [{RUNS['sweep'].seconds}, 121.2]]"
    yield Case("rate", "rate_1pc_sweep", f"sweep.*{rate}", partial(_commanded, name="sweep", rate_profile=profile))
    yield Case("rate", "rate_10pc_micro", f"micro_46.*{rate}", partial(_commanded, name="micro_46", rate="50.6"))
    gain = "(gain|calibrat|torque times)"
    for name in ("full_46", "sweep"):
        yield Case("gain", f"gain_{name}", f"{name}.*{gain}", partial(_changed, names=(name,), by=lambda y: 0.9 * y))
    steps = "(stepping|microsteps)"
    micro = {"stepping": '"micro"', "microsteps": "16"}
    yield Case("microsteps", "full_as_16", f"full_46.*{steps}", partial(_commanded, name="full_46", **micro))
    yield Case("microsteps", "16_as_full", f"micro_46.*{steps}", _micro_as_full)
    yield Case("microsteps", "16_as_8", f"micro_46.*({steps}|rate)", _microsteps_miscounted)
    yield Case(
        "microsteps", "full_as_half", f"full_46.*{steps}", partial(_commanded, name="full_46", stepping='"half"')
    )
    for one, other in (("full_46", "full_23"), ("full_46", "micro_46"), ("micro_92", "sweep")):
        words = f"({one}.*{other}|{other}.*{one}).*swapped|swapped.*({one}.*{other}|{other}.*{one})"
        yield Case("swapped records", f"{one}_{other}", words, partial(_exchanged, one=one, other=other))


def _rows_and_clocks() -> Iterator[Case]:
    gap = "(irregular time|comes .* after the stamp)"
    yield Case("lost rows", "one_row", f"full_46.*{gap}", partial(_without_rows, rows=slice(5000, 5001)))
    yield Case("lost rows", "fifty_rows", f"full_46.*{gap}", partial(_without_rows, rows=slice(5000, 5050)))
    jump = "full_46.*(lost|missing|gap|rows|jump|contradict|clock)"
    yield Case("lost rows", "fifty_bare", jump, partial(_without_rows, rows=slice(5000, 5050), bare=True))
    yield Case("lost rows", "row_twice", "full_46.*(repeated|irregular)", _row_twice)
    clock = "(clock|rate)"
    yield Case("clock", "one_percent_all", f"(all records|full_46|campaign).*{clock}", partial(_stretched, by=1.01))
    yield Case("clock", "one_percent_one", f"full_46.*{clock}", partial(_stretched, names=("full_46",), by=1.01))
    yield Case("clock", "200_ppm_all", f"(all|campaign|records?).*{clock}", partial(_stretched, by=1.0002))
    own = f"sweep.*{clock}|{clock}.*sweep"
    yield Case("clock", "200_ppm_sweep", own, partial(_stretched, names=("sweep",), by=1.0002))


def _units() -> Iterator[Case]:
    for unit, scale in (("mN m", 1e3), ("N cm", 1e2)):
        words, short = f"(unit|torque times {1.0 / scale:g})", unit.replace(" ", "")
        times = partial(np.multiply, scale)
        yield Case(unit, f"{short}_one", f"full_46.*{words}", partial(_changed, names=("full_46",), by=times))
        yield Case(unit, f"{short}_all", f"all records.*{words}", partial(_changed, names=RUNS, by=times))
    yield Case("ms for s", "ms_one", "full_46.*(ms|milliseconds)", partial(_stretched, names=("full_46",), by=1e3))
    yield Case("ms for s", "ms_all", "(ms|milliseconds)", partial(_stretched, by=1e3))
    yield Case("ms for s", "kHz_for_Hz", "full_46.*(kHz|hertz|sample_rate_hz)", _kilohertz)
    yield Case(
        "deg for rad",
        "start_angle_rad",
        "full_46.*(rad|start angle)",
        partial(_commanded, name="full_46", start_angle_deg="0.785398"),
    )
    yield Case(
        "Hz for rad/s",
        "housing_hertz",
        "housing.frequency.*(Hz|hertz)",
        partial(
            _entry, table="housing", key="frequency", value=5000.0 / 6.2832, low=2500.0 / 6.2832, high=9000.0 / 6.2832
        ),
    )


def _files() -> Iterator[Case]:
    yield Case("swapped columns", "values_exchanged", "full_46.*(another column|column the time)", _columns_exchanged)
    yield Case("swapped columns", "headers_exchanged", "full_46.*time_s.*does not measure torque", _headers_exchanged)
    yield Case("decimal comma", "semicolons", "", partial(_decimal_comma, delimiter=";"))
    yield Case("decimal comma", "commas", "full_46.*(comma|columns|fields)", partial(_decimal_comma, delimiter=","))


def _chains() -> Iterator[Case]:
    yield Case("clipped", "clipped_full", "full_46.*clip", partial(_changed, names=("full_46",), by=_clipped))
    yield Case("clipped", "clipped_sweep", "sweep.*clip", partial(_changed, names=("sweep",), by=_clipped))
    saturated = "full_46.*(saturat|compress|limit)"
    yield Case("saturated", "compressing_full", saturated, partial(_changed, names=("full_46",), by=_compressed))
    low = "(low-pass|anti_alias|cut-off)"
    yield Case("low-passed", "200_Hz_all", low, partial(_changed, names=RUNS, by=partial(_low_passed, hertz=200.0)))
    one = partial(_changed, names=("full_46",), by=partial(_low_passed, hertz=200.0))
    yield Case("low-passed", "200_Hz_one", f"full_46.*{low}", one)
    hum = "(hum|mains|50 Hz)"
    yield Case("hum", "hum_all", hum, partial(_changed, names=RUNS, by=partial(_humming, amplitude=0.03)))
    yield Case("hum", "hum_sweep", hum, partial(_changed, names=("sweep",), by=partial(_humming, amplitude=0.03)))


def _mechanisms() -> Iterator[Case]:
    yield Case(
        "bounds",
        "torque_constant",
        "stepper.torque_constant",
        partial(_entry, table="stepper", key="torque_constant", value=0.277, low=0.1, high=0.3),
    )
    yield Case(
        "bounds",
        "gear_stiffness",
        "gear.stiffness",
        partial(_entry, table="gear", key="stiffness", value=2200.0, low=1500.0, high=5000.0),
    )
    yield Case(
        "catalogue by 100",
        "rotor_inertia",
        "(rotor_inertia|unit in the mechanism)",
        partial(_known, table="stepper", key="rotor_inertia", factor=100.0),
    )
    yield Case(
        "catalogue by 100",
        "load_inertia",
        "(load.inertia|unit in the mechanism)",
        partial(_known, table="load", key="inertia", factor=100.0),
    )
    yield Case(
        "catalogue by 100",
        "torque_constant_free",
        "(torque_constant|unit in the mechanism)",
        partial(_entry, table="stepper", key="torque_constant", value=27.7, low=10.0, high=80.0),
    )
    yield Case(
        "catalogue by 100",
        "stiffness_free",
        "(gear.stiffness|unit in the mechanism)",
        partial(_entry, table="gear", key="stiffness", value=22.0, low=3.0, high=50.0),
    )


def _changed(files: Files, names: tuple[str, ...], by: Callable[[FloatArray], FloatArray]) -> None:
    for name in names:
        files.put(name, by(measured_torque(name)))


def _commanded(files: Files, name: str, **keys: str) -> None:
    files.commands[name] |= keys


def _micro_as_full(files: Files) -> None:
    del files.commands["micro_46"]["microsteps"]
    files.commands["micro_46"]["stepping"] = '"full"'


def _microsteps_miscounted(files: Files) -> None:
    """Count the driver's pulses as those of 8 microsteps: the rate is twice that in truth."""
    files.commands["micro_46"] |= {"microsteps": "8", "rate": "92.0"}


def _late(files: Files, names: tuple[str, ...], seconds: float) -> None:
    """Begin the command later than the recorder: rest stands before the motion."""
    rest = round(seconds * RATE_HZ)
    for name in names:
        y = clean_torque(name)
        files.put(name, as_measured(name, np.concatenate([np.full(rest, y[0]), y[: y.size - rest]])))


def _begun(files: Files, name: str, seconds: float) -> None:
    """Begin the recorder later than the command, its time at zero."""
    lost = round(seconds * RATE_HZ)
    y = measured_torque(name)[lost:]
    files.put(name, y, time_of(name)[: y.size])


def _exchanged(files: Files, one: str, other: str) -> None:
    files.texts[f"{one}.csv"] = csv_text(time_of(other), measured_torque(other))
    files.texts[f"{other}.csv"] = csv_text(time_of(one), measured_torque(one))


def _without_rows(files: Files, rows: slice, bare: bool = False) -> None:
    time, y = time_of("full_46"), measured_torque("full_46")
    kept = np.ones(y.size, dtype=bool)
    kept[rows] = False
    files.put("full_46", y[kept], time[kept])
    if bare:
        lines = files.texts["full_46.csv"].splitlines()
        files.texts["full_46.csv"] = "\n".join(line.split(",")[1] for line in lines) + "\n"
        files.entries["full_46"] |= BARE


def _row_twice(files: Files) -> None:
    time, y = time_of("full_46"), measured_torque("full_46")
    files.put("full_46", np.insert(y, 5000, y[5000]), np.insert(time, 5000, time[5000]))


def _stretched(files: Files, by: float, names: tuple[str, ...] = tuple(RUNS)) -> None:
    for name in names:
        files.put(name, measured_torque(name), by * time_of(name))


def _kilohertz(files: Files) -> None:
    y = measured_torque("full_46")
    files.texts["full_46.csv"] = "torque_Nm\n" + "".join(f"{value:.9e}\n" for value in y)
    files.entries["full_46"] |= {**BARE, "sample_rate_hz": "10.0"}


def _columns_exchanged(files: Files) -> None:
    files.texts["full_46.csv"] = csv_text(measured_torque("full_46"), time_of("full_46"))


def _headers_exchanged(files: Files) -> None:
    text = csv_text(time_of("full_46"), measured_torque("full_46"))
    files.texts["full_46.csv"] = text.replace(HEADER, "torque_Nm,time_s", 1)


def _decimal_comma(files: Files, delimiter: str) -> None:
    text = csv_text(time_of("full_46"), measured_torque("full_46"))
    files.texts["full_46.csv"] = text.replace(",", "\t").replace(".", ",").replace("\t", delimiter)


def _clipped(y: FloatArray) -> FloatArray:
    limit = 0.5 * float(np.abs(y).max())
    return np.clip(y, -limit, limit)


def _compressed(y: FloatArray) -> FloatArray:
    """Bend large torques, as a sensor does near its limit."""
    limit = 0.8 * float(np.abs(y).max())
    return np.asarray(limit * np.tanh(y / limit))


def _low_passed(y: FloatArray, hertz: float) -> FloatArray:
    return np.asarray(signal.sosfilt(signal.butter(4, hertz, fs=RATE_HZ, output="sos"), y))


def _humming(y: FloatArray, amplitude: float) -> FloatArray:
    return np.asarray(y + amplitude * np.sin(2.0 * np.pi * 50.0 * np.arange(y.size) / RATE_HZ + 0.4))


def _entry(files: Files, *, table: str, key: str, value: float, low: float, high: float) -> None:
    files.mechanism[table][key] = {"value": value, "min": low, "max": high}


def _known(files: Files, *, table: str, key: str, factor: float) -> None:
    files.mechanism[table][key] *= factor
