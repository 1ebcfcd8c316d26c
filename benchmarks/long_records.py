"""Peak memory and time of the commands against the length of a record, and the time its reader takes by format.

A synthetic record at 10 kHz: the demo's mechanism, driven by a profile of 10 s again and again (microsteps, 0 to 60
steps/s and back), with noise. It is made block by block and written as HDF5; the campaign's mechanism has two free
parameters that start 10 and 20 % off. Every command is a process of its own: its peak is VmHWM, its pages of files
included, its time CPU seconds. `validate` is the library's function of that name on the fit that identify left.

    python benchmarks/long_records.py [--lengths 1 60 600 3600] [--formats-at 600] [--folder DIR] [--out FILE]
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from bench_sweep import machine
from mechid.campaign import catalogue_mechanism, mechanism_text
from mechid.campaign.bench import TRUTH
from mechid.campaign.trajectory_file import record_rows
from mechid.command import Command, RateProfile
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.writing import write_atomically

RATE_HZ, NOISE_NM, PERIOD_S = 10_000.0, 0.002, 10.0
PROFILE = ((0.0, 0.0), (4.0, 60.0), (6.0, 60.0), (10.0, 0.0))
STARTS = {"gear.stiffness": 1.1, "gear.damping": 0.8}
COMMANDS = ("check", "simulate", "identify", "validate", "report")
MEASURED = """
import sys, time, resource
from pathlib import Path
sys.argv = ["mechid", *sys.argv[1:]]
if sys.argv[1] == "validate":
    from mechid.analysis import validate
    from mechid.campaign import load_campaign
    from mechid.identification.result.fit_file import read_fit
    campaign = load_campaign(sys.argv[2])
    found = validate(campaign, read_fit(Path(sys.argv[3]) / "estimate.json", campaign))
    print({name: one.channels["torque"].fit_percent for name, one in found.items()})
    code = 0
else:
    from mechid.cli.app import main
    try:
        main()
    except SystemExit as ended:
        code = ended.code or 0
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print("measured", int(status["VmHWM"].split()[0]) * 1024, time.process_time(), code)
"""
READ = """
import sys, time
from pathlib import Path
from mechid.records import read_record
from mechid.records.spec import ChannelSpec, RecordSpec
path, column = Path(sys.argv[1]), sys.argv[2]
wall, cpu = time.perf_counter(), time.process_time()
column = int(column) if column.isdigit() else column
rate = None if path.suffix == ".csv" else 10000.0
record = read_record(path, RecordSpec(name="run", path=path.name, sample_rate_hz=rate,
                                      channels=(ChannelSpec(quantity="torque", column=column),)))
wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print("measured", int(status["VmHWM"].split()[0]) * 1024, cpu, record.samples, wall)
"""


def main() -> None:
    """Make the records, measure, print the tables and save them."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--lengths", type=float, nargs="*", default=[1.0, 60.0, 600.0, 3600.0])
    asked.add_argument("--commands", nargs="*", default=COMMANDS)
    asked.add_argument("--formats-at", type=float, default=600.0)
    asked.add_argument("--folder", type=Path)
    asked.add_argument("--out", type=Path)
    arguments = asked.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.folder or Path(scratch)
        rows = [row for seconds in arguments.lengths for row in _commands(folder, seconds, arguments.commands)]
        formats = list(_formats(folder, arguments.formats_at)) if arguments.formats_at else []
    if arguments.out:
        content = {"machine": machine(), "commands": rows, "formats": formats}
        write_atomically(arguments.out, json.dumps(content, indent=1) + "\n")


def _commands(folder: Path, seconds: float, commands: list[str]) -> Iterator[dict]:
    campaign = made(folder / f"{seconds:g}", seconds)
    result = campaign / "result"
    asked = {
        "check": ["check", campaign],
        "simulate": ["simulate", campaign, "--out", campaign / "simulated"],
        "identify": ["identify", campaign, "--out", result],
        "validate": ["validate", campaign, result],
        "report": ["report", result],
    }
    for name in commands:
        peak, cpu, code, *_ = measured_in_a_process(MEASURED, asked[name])
        row = {"seconds": seconds, "command": name, "peak_bytes": peak, "cpu_s": cpu, "exit": code}
        print(f"| {seconds:g} s | {name} | {peak / 1e6:.0f} MB | {cpu:.1f} s | exit {code:.0f} |", flush=True)
        yield row


def _formats(folder: Path, seconds: float) -> Iterator[dict]:
    campaign = made(folder / f"{seconds:g}", seconds)
    for name, (suffix, write) in WRITERS.items():
        path = campaign / f"run.{suffix}"
        if not path.exists():
            write(campaign, path)
        column = "1" if suffix == "csv" else "0" if suffix == "npy" else "torque"
        peak, cpu, samples, wall = measured_in_a_process(READ, [path, column])
        row = {
            "seconds": seconds,
            "format": name,
            "peak_bytes": peak,
            "cpu_s": cpu,
            "wall_s": wall,
            "samples": samples,
            "file_bytes": path.stat().st_size,
        }
        print(f"| {name} | {path.stat().st_size / 1e6:.0f} MB | {cpu:.2f} s | {peak / 1e6:.0f} MB |", flush=True)
        yield row


def measured_in_a_process(script: str, arguments: list) -> list[float]:
    """Run a script that prints what it measured of itself, and return these numbers."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    last = [line for line in done.stdout.splitlines() if line.startswith("measured ")]
    if not last:
        raise SystemExit(done.stdout[-2000:] + done.stderr[-4000:])
    if "error" in done.stderr:
        print(done.stderr[-1000:], file=sys.stderr)
    return [float(word) for word in last[-1].split()[1:]]


def made(folder: Path, seconds: float) -> Path:
    """Write the campaign of so many seconds, where it is not there yet, and return its folder."""
    if (folder / "campaign.toml").exists():
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    turns = int(np.ceil(seconds / PERIOD_S))
    points = [(PERIOD_S * turn + t, rate) for turn in range(turns) for t, rate in PROFILE[bool(turn) :]]
    write_atomically(folder / "rate.csv", "time_s,rate\n" + "".join(f"{t:.9g},{rate:.9g}\n" for t, rate in points))
    truth = catalogue_mechanism().with_values(TRUTH)
    off = {name: truth.value(name) * factor for name, factor in STARTS.items()}
    start = truth.with_free(tuple(STARTS)).with_values(off)
    write_atomically(folder / "mechanism.toml", mechanism_text(start, "SYNTHETIC, two parameters free"))
    command = Command(stepping="micro", microsteps=16, rate=RateProfile.through(points))
    base = TimeBase(RATE_HZ, round(seconds * RATE_HZ) + 1)
    _write_hdf5(folder / "run.h5", base, Simulator(truth.plant, command, base).run(truth.kernel_values(), substeps=2))
    write_atomically(
        folder / "campaign.toml",
        'mechanism = "mechanism.toml"\n\n[[record]]\nname = "run"\nfile = "run.h5"\nsample_rate_hz = 10000.0\n'
        'command = { stepping = "micro", microsteps = 16, rate_table = "rate.csv" }\n'
        'channels = [{ quantity = "torque", column = "torque" }]\n',
    )
    return folder


def _write_hdf5(path: Path, base: TimeBase, run) -> None:
    import h5py

    noise = np.random.default_rng(7)
    with h5py.File(path, "w") as file:
        torque = file.create_dataset("torque", (base.samples,), "f8", chunks=(min(2**16, base.samples),))
        for block in run.blocks():
            y = block.y[:, 0]
            torque[block.start : block.stop] = y + NOISE_NM * noise.standard_normal(y.size)


def _torque(campaign: Path) -> np.ndarray:
    import h5py

    with h5py.File(campaign / "run.h5") as file:
        return file["torque"][:]


def _hdf5_gzip(campaign: Path, path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("torque", data=_torque(campaign), chunks=(2**16,), compression="gzip", compression_opts=4)


def _matlab73(campaign: Path, path: Path) -> None:
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        data = file.create_dataset("torque", data=_torque(campaign)[None], chunks=(1, 2**16), compression="gzip")
        data.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, made for a benchmark".ljust(124) + b"\x00\x02IM")


def _tdms(campaign: Path, path: Path) -> None:
    import nptdms

    torque = _torque(campaign)
    with nptdms.TdmsWriter(path) as file:
        for first in range(0, torque.size, 100_000):  # ten seconds a segment, as a recorder flushes them
            file.write_segment([nptdms.ChannelObject("run", "torque", torque[first : first + 100_000])])


def _parquet(campaign: Path, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"torque": _torque(campaign)}), path)


def _parquet_one_group(campaign: Path, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    torque = _torque(campaign)
    pq.write_table(pa.table({"torque": torque}), path, row_group_size=torque.size)


def _csv(campaign: Path, path: Path) -> None:
    torque = _torque(campaign)
    write_atomically(
        path, record_rows(np.arange(torque.size) / RATE_HZ, torque, time_format="%.4f", torque_format="%.6e")
    )


WRITERS: dict[str, tuple[str, Callable[[Path, Path], None]]] = {
    "HDF5": ("h5", lambda campaign, path: None),
    "HDF5, gzip": ("gzip.h5", _hdf5_gzip),
    "MATLAB 7.3": ("mat", _matlab73),
    "TDMS": ("tdms", _tdms),
    "Parquet": ("parquet", _parquet),
    "Parquet, one row group": ("one.parquet", _parquet_one_group),
    "NPY": ("npy", lambda campaign, path: np.save(path, _torque(campaign))),
    "CSV, time and torque": ("csv", _csv),
}

if __name__ == "__main__":
    main()
