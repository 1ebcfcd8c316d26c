"""The command line: one function per verb, each parses, calls, prints.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

import signal
import sys

__all__ = ["main"]

INTERRUPTED = 130
ENDED_BY = ("SIGTERM", "SIGHUP")
"""Signals of batch systems and of terminals that are closed; Windows has the first alone."""


def main() -> None:
    """Run the command line; never returns."""
    _end_as_by_ctrl_c()
    try:
        from mechid.cli import app  # here, so that Ctrl-C while it loads is answered like any other

        app.main()
    except KeyboardInterrupt:
        sys.stderr.write("mechid: interrupted\n")
        sys.exit(INTERRUPTED)


def _end_as_by_ctrl_c() -> None:
    """Have all that ends a command keep what Ctrl-C keeps; a signal that is ignored, as under nohup, stays so."""
    for number in (getattr(signal, name) for name in ENDED_BY if hasattr(signal, name)):
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)
