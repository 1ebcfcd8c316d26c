"""Run mechid's command line as ``python -m mechid``."""

from mechid.cli import main

main()
