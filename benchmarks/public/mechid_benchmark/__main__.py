"""Command line of the benchmark: ``python -m mechid_benchmark score SUBMISSION.json``."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from .answers import read_answers
from .scores import score_submission, table
from .submission import SubmissionError, read_submission

WRONG_SUBMISSION = 3
"""Exit code of a submission that cannot be scored; a wrong command line has 2."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Score a submission, print the table, and return the exit code."""
    parser = argparse.ArgumentParser(prog="mechid_benchmark", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    score = commands.add_parser("score", help="score a submission")
    score.add_argument("submission", type=Path, metavar="SUBMISSION.json")
    score.add_argument("--json", action="store_true", help="print every number as JSON instead of the table")
    asked = parser.parse_args(arguments)
    try:
        submission = read_submission(asked.submission)
    except SubmissionError as error:
        print(error, file=sys.stderr)
        return WRONG_SUBMISSION
    found = score_submission(submission, read_answers())
    print(json.dumps(found, indent=1) if asked.json else f"{found['name']}\n\n{table(found)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
