"""Command line: one function per verb, which parses arguments, calls the library and prints.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

import sys

from mechid.cli import termination

__all__ = ["main"]


def main() -> None:
    """Run the command line; never returns."""
    try:
        termination.listen_for_signals()
        # Imported here, so that Ctrl-C during the import is handled like any other.
        from mechid.cli import app

        app.main()
    except KeyboardInterrupt:
        termination.say_interrupted()
        if termination.is_interrupted():
            termination.end(termination.INTERRUPTED)
        sys.exit(termination.INTERRUPTED)
    except Exception:
        if not termination.is_interrupted():
            raise
        # Python raises a different error if the interrupt falls into the creation of a class.
        termination.say_interrupted()
        termination.end(termination.INTERRUPTED)
    except SystemExit as left:
        if termination.is_interrupted():
            termination.end(left.code if isinstance(left.code, int) else 0)
        raise
    finally:
        termination.finish()
