"""The command line: one function per verb, each parses, calls, prints.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.cli.app import main

__all__ = ["main"]
