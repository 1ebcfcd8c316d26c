"""Batches of tasks on a worker. Truth: the same work in this process, and the versions and folders that it is given."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pytest

import chores
from finished import optimum
from mechid.errors import WorkersError
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.workforce import working_on
from mechid.identification.refit.bootstrap import bootstrap

SPAWN = get_context("spawn")


@pytest.fixture(scope="module")
def housing():
    return optimum("housing.gain", "housing.frequency")


def test_a_worker_of_another_version_is_refused_by_name():
    said = r"worker \S+:\d+ is refused: it has mechid 0\.0\.9; here is mechid 0\.1"
    odd = ProcessPoolExecutor(1, mp_context=SPAWN, initializer=chores.of_another_version)
    with odd, working_on(odd), pytest.raises(WorkersError, match=said):
        map_tasks(partial(chores.squared, 0), range(3), 1)


def without_cache(folder):
    """Return a process that cannot write to its cache: root may write anywhere, but not below a file."""
    (folder / "file").touch()
    blocked = str(folder / "file" / "cache")
    return ProcessPoolExecutor(1, mp_context=SPAWN, initializer=chores.without_cache, initargs=(blocked,))


def test_a_worker_that_cannot_write_to_its_cache_says_so_once(tmp_path):
    told = []
    with without_cache(tmp_path) as odd, working_on(odd, told.append):
        folders = map_tasks(chores.cache_of, range(3), 1)
    assert len(set(folders)) == len(told) == 1
    assert folders[0] != str(tmp_path / "file" / "cache")
    assert not Path(folders[0]).exists(), "it is gone with its process"
    assert "cannot write to" in told[0]
    assert "temporary folder" in told[0]


@pytest.mark.slow
def test_a_worker_that_cannot_write_to_its_cache_compiles_elsewhere(tmp_path, housing):
    with without_cache(tmp_path) as odd, working_on(odd, lambda line: None):
        there = bootstrap(housing, 2)
    assert repr(there.draws) == repr(bootstrap(housing, 2).draws)
