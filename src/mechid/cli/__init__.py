"""Command line: one function per verb, which parses arguments, calls the library and prints.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

import sys

from mechid.cli import ending

__all__ = ["main"]


def main() -> None:
    """Run the command line; never returns."""
    try:
        ending.listen_for_signals()
        # Imported here, so that Ctrl-C during the import is handled like any other.
        from mechid.cli import app

        app.main()
    except KeyboardInterrupt:
        ending.say_interrupted()
        if ending.is_interrupted():
            ending.end(ending.INTERRUPTED)
        sys.exit(ending.INTERRUPTED)
    except Exception:
        if not ending.is_interrupted():
            raise
        # Python raises a different error if the interrupt falls into the creation of a class.
        ending.say_interrupted()
        ending.end(ending.INTERRUPTED)
    except SystemExit as left:
        if ending.is_interrupted():
            ending.end(left.code if isinstance(left.code, int) else 0)
        raise
    finally:
        ending.finish()
