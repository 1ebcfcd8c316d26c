"""The command line: one function per verb, each parses, calls, prints.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

import sys

__all__ = ["main"]

INTERRUPTED = 130


def main() -> None:
    """Run the command line; never returns."""
    try:
        from mechid.cli import app  # here, so that Ctrl-C while it loads is answered like any other

        app.main()
    except KeyboardInterrupt:
        sys.stderr.write("mechid: interrupted\n")
        sys.exit(INTERRUPTED)
