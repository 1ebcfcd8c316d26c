"""One record of a sine, from everything that can hold samples in memory."""

import numpy as np
import pandas as pd
import xarray as xr

import mechid

RATE_HZ = 1000.0
TIME = np.arange(400) / RATE_HZ
TORQUE = np.sin(2.0 * np.pi * 46.0 * TIME)
COMMAND = mechid.make_command("full", rate=46.0)


def named(columns):
    """Return a DataFrame with dates for an index, as loggers give it."""
    return pd.DataFrame(columns, index=pd.Timestamp("2026-01-01") + pd.to_timedelta(TIME, unit="s"))


SOURCES = {
    "array and rate": lambda: mechid.make_record("a", TORQUE, sample_rate_hz=RATE_HZ, command=COMMAND),
    "array and times": lambda: mechid.make_record("a", TORQUE, time_s=TIME, command=COMMAND),
    "list": lambda: mechid.make_record("a", TORQUE.tolist(), sample_rate_hz=RATE_HZ, command=COMMAND),
    "mapping": lambda: mechid.make_record("a", {"time_s": TIME, "torque_mNm": 1e3 * TORQUE}, command=COMMAND),
    "series": lambda: mechid.make_record("a", pd.Series(TORQUE, index=TIME), command=COMMAND),
    "frame": lambda: mechid.make_record("a", pd.DataFrame({"time_s": TIME, "torque": TORQUE}), command=COMMAND),
    "frame over dates": lambda: mechid.make_record("a", named({"torque [Nmm]": 1e3 * TORQUE}), command=COMMAND),
    "data array": lambda: mechid.make_record("a", xr.DataArray(TORQUE, coords={"t": TIME}, dims="t"), command=COMMAND),
    "data set": lambda: mechid.make_record(
        "a", xr.Dataset({"torque": ("t", 1e3 * TORQUE, {"units": "mN*m"})}, coords={"t": TIME}), command=COMMAND
    ),
    "array and rate, nothing masked": lambda: mechid.make_record(
        "a", np.ma.array(TORQUE), sample_rate_hz=RATE_HZ, command=COMMAND
    ),
    "times and their rate": lambda: mechid.make_record(
        "a", {"time_s": TIME, "torque": TORQUE}, sample_rate_hz=RATE_HZ, command=COMMAND
    ),
    "series over numbers of rows": lambda: mechid.make_record(
        "a", pd.Series(TORQUE, index=7 + np.arange(400)), sample_rate_hz=RATE_HZ, command=COMMAND
    ),
    "channels": lambda: mechid.make_record(
        "a",
        {"Mz": -TORQUE},
        sample_rate_hz=RATE_HZ,
        command=COMMAND,
        channels=[{"quantity": "torque", "column": "Mz", "gain": -1.0}],
    ),
}
