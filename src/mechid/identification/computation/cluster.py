"""The workers of a Dask scheduler, by its address: the home of Dask."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from mechid.errors import UsageError, WorkersError
from mechid.identification.computation.progress import Tell
from mechid.identification.computation.settings import WORK
from mechid.identification.computation.workforce import warn, working_on

QUIET = ("distributed", "distributed.client", "distributed.core", "distributed.comm", "asyncio", "tornado.application")
"""Loggers that print a traceback where a connection is lost; a scheduler may also go when its work is done."""


@contextmanager
def lent_by(address: str | None, say: Tell = warn) -> Iterator[None]:
    """Let the workers of the Dask scheduler at an address do what is mapped within; None leaves it to this process.

    Parameters
    ----------
    address : str or None
        As ``tcp://host:8786``, which a scheduler writes when it starts.
    say : callable
        Called with a line on what is odd about workers.

    Raises
    ------
    UsageError
        Dask is not installed.
    WorkersError
        There is no scheduler at the address, or it is lost on the way.
    """
    if address is None:
        yield
        return
    with _client(address) as client:
        if not client.nthreads():
            say(f"scheduler {address}: it has no workers yet; waiting for them")
        with working_on(client.get_executor(), say):
            yield


def _client(address: str) -> Any:
    """Return a client of a scheduler; what that would say of a lost connection is said in the error."""
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError('--scheduler needs Dask; install it with pip install "mechid[cluster]"') from error
    for name in QUIET:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=WORK.scheduler_patience_s, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        what = " ".join(str(error).split())
        raise WorkersError(
            f"--scheduler {address}: no Dask scheduler answers there ({what}); "
            "give the address that it writes when it starts, as tcp://host:8786"
        ) from error
