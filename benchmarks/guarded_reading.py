"""What it costs that records are read in a process of their own: a campaign loaded so, and with its readers here.

The demo's SYNTHETIC bench, its records also written as HDF5, MATLAB 7.3, MATLAB 5 and Parquet. Each load is a process
of its own, both ways in turn; time is that of `load_campaign`, CPU seconds are all of both processes; medians. Then an
hour at 10 kHz as HDF5, from the file to samples in SI.

    python benchmarks/guarded_reading.py [--times 7] [--hour-s 3600] [--out FILE]
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import scipy.io

from bench_sweep import machine
from mechid.campaign.bench import write_bench

LOAD = """
import sys, time, resource
guarded, what = sys.argv[1] == "guarded", sys.argv[2]
from pathlib import Path
from mechid.records import formats
if not guarded:
    formats.GUARDED = {}
if Path(what).is_dir():
    from mechid.campaign import load_campaign
    before = time.perf_counter()
    load_campaign(what)
else:
    from mechid.records import RecordSpec, read_record
    before = time.perf_counter()
    read_record(Path(what), RecordSpec(name="run", path=what, sample_rate_hz=1e4))
wall = time.perf_counter() - before
from mechid.reading.process import _READER
if _READER._child is not None:  # by its own end, so that its seconds are counted
    _READER._child.stdin.close()
    _READER._child.wait()
here, there = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(wall, here.ru_utime + here.ru_stime, there.ru_utime + there.ru_stime)
"""
FORMATS = ("csv", "h5", "mat 7.3", "mat 5", "parquet")


def main() -> None:
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        os.environ["MECHID_CACHE"] = str(place / "cache")
        write_bench(place / "csv", seed=3)
        rows = []
        for form in FORMATS:
            rows.append({"what": f"the demo's campaign, {form}", **_both(str(_campaign(place, form)), arguments.times)})
            _show(rows[-1])
        if arguments.hour_s:
            rows.append({"what": f"{arguments.hour_s} s at 10 kHz, h5", **_both(_long(place, arguments.hour_s), 3)})
            _show(rows[-1])
    if arguments.out:
        arguments.out.write_text(json.dumps({"machine": machine(), "rows": rows}, indent=1) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=7)
    parser.add_argument("--hour-s", type=int, default=3600)
    parser.add_argument("--out", type=Path)
    return parser.parse_args()


def _both(what: str, times: int) -> dict:
    """Return wall and CPU seconds of a load, guarded and not, the extra ones among them."""
    _load("guarded", what)
    found = {way: [] for way in ("guarded", "here")}
    for _ in range(times):
        for way, numbers in found.items():
            numbers.append(_load(way, what))
    median = {way: [statistics.median(each) for each in zip(*numbers, strict=True)] for way, numbers in found.items()}
    row = {way: dict(zip(("wall_s", "cpu_s", "cpu_there_s"), numbers, strict=True)) for way, numbers in median.items()}
    wall = row["guarded"]["wall_s"] - row["here"]["wall_s"]
    cpu = sum(median["guarded"][1:]) - sum(median["here"][1:])
    return {**row, "extra_wall_s": wall, "extra_cpu_s": cpu}


def _load(way: str, what: str) -> list[float]:
    done = subprocess.run([sys.executable, "-c", LOAD, way, what], capture_output=True, text=True, check=True)
    return [float(number) for number in done.stdout.split()]


def _show(row: dict) -> None:
    numbers = ", ".join(f"{way} {row[way]['wall_s']:.3f} s" for way in ("here", "guarded"))
    print(f"{row['what']}: {numbers}; extra {row['extra_wall_s']:.3f} s, {row['extra_cpu_s']:.3f} s of CPU")


def _campaign(place: Path, form: str) -> Path:
    """Return the folder of the demo's campaign with its records in another format."""
    if form == "csv":
        return place / "csv"
    folder, suffix = place / form.replace(" ", ""), form.split(maxsplit=1)[0]
    folder.mkdir()
    text = (place / "csv/campaign.toml").read_text(encoding="utf-8")
    for path in (place / "csv").glob("*.csv"):
        if f'"{path.name}"' in text:
            _written(folder / f"{path.stem}.{suffix}", form, np.loadtxt(path, delimiter=",", skiprows=1).T)
            text = text.replace(f'"{path.name}"', f'"{path.stem}.{suffix}"')
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    (folder / "mechanism.toml").write_text((place / "csv/mechanism.toml").read_text(encoding="utf-8"), encoding="utf-8")
    return folder


def _written(path: Path, form: str, columns: np.ndarray) -> None:
    named = dict(zip(("time", "torque"), columns, strict=True))
    if form == "mat 5":
        scipy.io.savemat(path, named, do_compression=True)
    elif form == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table(named), path)
    else:
        _write_hdf5(path, named, userblock=form == "mat 7.3")


def _write_hdf5(path: Path, named: dict[str, np.ndarray], *, userblock: bool) -> None:
    import h5py

    with h5py.File(path, "w", userblock_size=512 if userblock else 0) as file:
        for name, values in named.items():
            file[name] = values
    if userblock:
        with path.open("r+b") as opened:
            opened.write(b"MATLAB 7.3 MAT-file".ljust(512))


def _long(place: Path, seconds: int) -> str:
    import h5py

    with h5py.File(place / "long.h5", "w") as file:
        torque = file.create_dataset("torque", shape=(seconds * 10_000,), chunks=(2**16,), dtype=float)
        rng = np.random.default_rng(1)
        for start in range(0, seconds * 10_000, 2**20):
            torque[start : start + 2**20] = rng.standard_normal(min(2**20, seconds * 10_000 - start))
    return str(place / "long.h5")


if __name__ == "__main__":
    main()
