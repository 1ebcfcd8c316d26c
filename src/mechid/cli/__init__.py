"""The command line: one function per verb, each parses, calls, prints."""

from mechid.cli.app import main

__all__ = ["main"]
