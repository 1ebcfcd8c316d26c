"""A value that takes long to work out: one process of a test run makes it, the others read it."""

import os
import pickle

from mechid.kernel.cache_files import lock_kernel


def once(tmp_path_factory, name, make):
    """Return what `make` returns; with pytest-xdist one worker calls it, and the others wait and unpickle its result.

    The result has to be picklable, and nobody may change it.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # each worker has its own folder in that of the run
    kept = folder / f"{name}.pickle"
    with lock_kernel(kept):
        if not kept.exists():
            made = kept.with_suffix(f".{os.getpid()}")  # where nothing is locked, nobody reads half of it
            made.write_bytes(pickle.dumps(make()))
            made.replace(kept)
        return pickle.loads(kept.read_bytes())
