"""Files of HDF5 and MATLAB that lead elsewhere or in circles: each by a named builder, with TORQUE in `torque`."""

import numpy as np

TIME = np.arange(64) / 1000.0
TORQUE = np.sin(0.3 * np.arange(64.0))
SECRET = np.linspace(1.0, 2.0, 64)
"""What another file holds."""


def record(file):
    file["time"], file["torque"] = TIME, TORQUE


def two_groups_in_a_circle(file):
    a, b = file.create_group("a"), file.create_group("b")
    a["b"], b["a"], a["x"] = b, a, TORQUE


def a_group_that_holds_itself_twice(file):
    group = file.create_group("a")
    group["once"], group["again"] = group, group


def a_soft_link_to_the_top(file):
    import h5py

    file.create_group("a")["up"] = h5py.SoftLink("/")


def soft_links_in_a_circle(file):
    import h5py

    file["a"], file["b"] = h5py.SoftLink("/b"), h5py.SoftLink("/a")


CIRCLES = (two_groups_in_a_circle, a_group_that_holds_itself_twice, a_soft_link_to_the_top, soft_links_in_a_circle)


def a_ladder_of_links(file, steps=32):
    """Write 2^32 paths: each group holds the next one twice."""
    group = file
    for _ in range(steps):
        below = group.create_group("a")
        group["b"] = below
        group = below


def other(folder):
    """Write the file that the others name."""
    import h5py

    with h5py.File(folder / "other.h5", "w") as file:
        file["x"] = SECRET
    (folder / "raw.bin").write_bytes(SECRET.tobytes())


def an_external_link(file):
    import h5py

    file["x"] = h5py.ExternalLink("other.h5", "/x")
    return "other.h5"


def a_group_of_another_file(file):
    import h5py

    file["whole"] = h5py.ExternalLink("other.h5", "/")
    file["x"] = h5py.SoftLink("/whole/x")
    return "other.h5"


def raw_storage(file):
    file.create_dataset("x", shape=(64,), dtype=float, external=[("raw.bin", 0, 512)])
    return "raw.bin"


def a_virtual_dataset(file):
    import h5py

    layout = h5py.VirtualLayout((64,), float)
    layout[:] = h5py.VirtualSource("other.h5", "x", (64,))
    file.create_virtual_dataset("x", layout)
    return "other.h5"


def a_virtual_dataset_of_raw_storage(file):
    import h5py

    layout = h5py.VirtualLayout((64,), float)
    layout[:] = h5py.VirtualSource(".", "/hidden", (64,))
    file.create_dataset("hidden", shape=(64,), dtype=float, external=[("raw.bin", 0, 512)])
    file.create_virtual_dataset("x", layout)
    return "raw.bin"


REFERENCES = (
    an_external_link,
    a_group_of_another_file,
    raw_storage,
    a_virtual_dataset,
    a_virtual_dataset_of_raw_storage,
)


def written(path, build):
    """Write a record and what else a builder makes; return what that returns. A .mat file is one of version 7.3."""
    import h5py

    with h5py.File(path, "w", userblock_size=512 if path.suffix == ".mat" else 0) as file:
        record(file)
        found = build(file)
    if path.suffix == ".mat":
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))
    return found
