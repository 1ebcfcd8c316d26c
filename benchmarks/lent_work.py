"""What lending work out costs: seconds of processor a batch, here and on a worker, and what follows for many workers.

Tasks that do nothing go out one to a batch, to processes and to a Dask cluster of this machine, whose scheduler is a
process of its own. What is measured is processor time, which other work on the machine does not lengthen; the wall
time of one batch alone is the shortest of many. Then draws of a bootstrap are done here and lent out, and their
processor time compared.

    python benchmarks/lent_work.py [FIT] [--batches 2000] [--draws 20] [--out FILE]
"""

import argparse
import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

import psutil

from bench_sweep import RESULTS, machine
from mechid.fits.load import load_fit
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import map_tasks, one_core_algebra
from mechid.identification.computation.settings import WORK
from mechid.identification.computation.workforce import working_on
from mechid.identification.refit.bootstrap import bootstrap

ALONE = 200
"""Batches sent alone, of which the shortest counts."""
WORKERS = (1, 2)
DRAW_S, DRAWS, MANY = 0.8, 10_000, (10, 100)
"""Of the case worked out on paper: seconds a draw where none is measured, draws, workers."""
START_S = 5.0
"""A worker's imports and its kernel read from its cache."""


def nothing(problem, number):
    """Return the number."""
    return number


@contextmanager
def pool(count):
    """Lend `count` processes; yield the executor and the processes that are neither here nor workers."""
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as executor:
        yield executor, []


@contextmanager
def dask(count):
    """Lend the workers of a scheduler; all are processes of their own."""
    from distributed import Client

    with ExitStack() as stack:
        file = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "scheduler.json"
        scheduler = _begun(stack, "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
        for _ in range(count):
            _begun(stack, "worker", "--scheduler-file", file, "--nthreads", "1", "--no-nanny")
        client = stack.enter_context(Client(scheduler_file=str(file), timeout=60, set_as_default=False))
        client.wait_for_workers(count)
        yield client.get_executor(), [psutil.Process(scheduler.pid)]


def _begun(stack, program, *arguments):
    command = [sys.executable, "-W", "ignore", "-m", f"distributed.cli.dask_{program}", "--no-dashboard"]
    process = subprocess.Popen([*command, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process


def spent(scheduler):
    """Return processor seconds so far: of this process, the scheduler, the workers."""
    known = {p.pid for p in scheduler}
    workers = [p for p in psutil.Process().children(recursive=True) if p.pid not in known]
    return [
        sum(p.cpu_times().user + p.cpu_times().system for p in some)
        for some in ([psutil.Process()], scheduler, workers)
    ]


def overhead(lend, count, batches):
    """Return milliseconds a batch of one empty task: processor time by place, and the wall time of one alone."""
    work = partial(import_module("lent_work").nothing, b"")
    kept, WORK.batch_s = WORK.batch_s, 0.0
    try:
        with lend(count) as (executor, scheduler), working_on(executor):
            map_tasks(work, range(4 * count), 1)
            before = spent(scheduler)
            map_tasks(work, range(batches), 1)
            here, between, there = ((b - a) / batches * 1e3 for a, b in zip(before, spent(scheduler), strict=True))
            walls = []
            for number in range(ALONE):
                began = time.perf_counter()
                map_tasks(work, [number], 1)
                walls.append(time.perf_counter() - began)
    finally:
        WORK.batch_s = kept
    return {"here_ms": here, "scheduler_ms": between, "worker_ms": there, "alone_wall_ms": min(walls) * 1e3}


def noting(lines=200):
    """Return milliseconds that a line of a journal takes until it is on this disk."""
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal.open(Path(folder) / "journal.jsonl", {})
        began = time.perf_counter()
        for number in range(lines):
            journal.step("nothing", [number], dict)
        return (time.perf_counter() - began) / lines * 1e3


def drawn(fit, draws):
    """Return processor seconds a draw, here and lent to one and two workers, and megabytes of the problem."""
    with one_core_algebra():
        optimum = load_fit(fit).optimum_on(1)
        bootstrap(optimum, 2)
        began = time.process_time()
        here = bootstrap(optimum, draws)
        rows = {"here_s": (time.process_time() - began) / draws, "problem_MB": len(pickle.dumps(optimum)) / 1e6}
        for count in WORKERS:
            with dask(count) as (executor, scheduler), working_on(executor):
                bootstrap(optimum, 2 * count)
                before = spent(scheduler)
                there = bootstrap(optimum, draws)
                names = ("client_s", "scheduler_s", "worker_s")
                each = dict(
                    zip(names, ((b - a) / draws for a, b in zip(before, spent(scheduler), strict=True)), strict=True)
                )
                rows[f"workers_{count}"] = each | {"same_to_the_last_bit": repr(there.draws) == repr(here.draws)}
    return rows


def efficiency(workers, tasks, task_s, batch, serial_s, worker_s):
    """Return the share of the workers' time that is work, on paper.

    E = W / (W + losses), W = tasks * task_s the work. A worker loses `worker_s` a batch; at the beginning it loses
    START_S, at the end half a batch on the average; and where batches end faster than client and scheduler can serve
    them, in `serial_s` each, it waits for these.
    """
    batch_s = batch * task_s
    batches = tasks / batch
    busy = tasks * task_s + batches * worker_s + workers * (START_S + 0.5 * batch_s)
    return tasks * task_s / max(busy, workers * batches * serial_s)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("fit", type=Path, nargs="?", help="result folder of mechid identify")
    parser.add_argument("--batches", type=int, default=2000)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    result = {"machine": machine(), "batches": arguments.batches, "journal_line_ms": noting()}
    result["overhead"] = {
        f"{lend.__name__}_{count}": overhead(lend, count, arguments.batches)
        for lend in (pool, dask)
        for count in WORKERS
    }
    if arguments.fit:
        result["bootstrap"] = {"draws": arguments.draws, **drawn(arguments.fit, arguments.draws)}
    cost = result["overhead"]["dask_2"]
    task_s = result.get("bootstrap", {}).get("here_s", DRAW_S)
    serial_s = 1e-3 * max(cost["here_ms"], cost["scheduler_ms"])  # the journal waits once for all that is ready
    batch = max(int(-(-WORK.batch_s // task_s)), 1)
    result["on_paper"] = {
        "draws": DRAWS,
        "draw_s": task_s,
        "tasks_a_batch": batch,
        "serial_ms": serial_s * 1e3,
        **{f"efficiency_{n}": efficiency(n, DRAWS, task_s, batch, serial_s, 1e-3 * cost["worker_ms"]) for n in MANY},
    }
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%S")
    out = arguments.out or RESULTS / f"lent-work-{stamp}.json"
    out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
