"""The command line: one function per verb, each parses, calls, prints.

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
        from mechid.cli import app  # here, so that Ctrl-C while it loads is answered like any other

        app.main()
    except KeyboardInterrupt:
        ending.say_interrupted()
        if ending.is_interrupted():
            ending.end(ending.INTERRUPTED)
        sys.exit(ending.INTERRUPTED)
    except Exception:
        if not ending.is_interrupted():
            raise
        ending.say_interrupted()  # Python raises another error where a class that is being made is interrupted
        ending.end(ending.INTERRUPTED)
    except SystemExit as left:
        if ending.is_interrupted():
            ending.end(left.code if isinstance(left.code, int) else 0)
        raise
    finally:
        ending.finish()
