"""Files of integers with attributes that say how they are scaled."""

import numpy as np

RATE = 1000.0
TIME = np.arange(200) / RATE
COUNTS = np.round(7000.0 * np.sin(0.3 * np.arange(200.0))).astype(np.int16)


def write_hdf5(path, numbers, **attributes):
    import h5py

    with h5py.File(path, "w") as file:
        file["run/time"] = TIME
        file["run/torque"] = numbers
        file["run/torque"].attrs.update(attributes)
