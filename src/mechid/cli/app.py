"""Command ``mechid``: its verbs, and the conversion of errors to exit codes.

Heavy modules are imported inside the verbs, which keeps ``mechid --help`` fast.
"""

from __future__ import annotations

import errno
import gc
import os
import re
import sys
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from itertools import pairwise
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from mechid.cli.bootstrap import bootstrap
from mechid.cli.budget import budget
from mechid.cli.check import check
from mechid.cli.compare import compare
from mechid.cli.demo import demo
from mechid.cli.design import design
from mechid.cli.diagnose import diagnose
from mechid.cli.emission import emission
from mechid.cli.environment import refuse_surroundings
from mechid.cli.explore import explore
from mechid.cli.export import export
from mechid.cli.fleet import fleet
from mechid.cli.identify import identify
from mechid.cli.kernel import kernel
from mechid.cli.look import look
from mechid.cli.new import new
from mechid.cli.open import open_index
from mechid.cli.profile import profile
from mechid.cli.quiet import quiet
from mechid.cli.report import report
from mechid.cli.simulate import simulate
from mechid.cli.standard_streams import NOBODY_READS, ReaderGoneError, prepare_streams
from mechid.cli.termination import INTERRUPTED, is_interrupted, say_interrupted
from mechid.errors import DEBUG, MechidError, UsageError
from mechid.writing import protect_read_files

UNEXPECTED, USAGE = 1, UsageError.exit_code
NO_MEMORY = (
    "not enough memory for this; close other programs, raise the limit of the process (ulimit -v), or give fewer or "
    "shorter records (window_s)"
)
LETTERS = 200
LONG_WORD = re.compile(rf"\S{{{2 * LETTERS},}}")
"""Word in a message that is too long for a real path or name."""
COLLECTED = 50_000
"""Threshold of the garbage collector; with Python's default of 700, collections add half a second to the imports."""
EPILOG = (
    "Exit codes: 0 good, 1 a fault of mechid's own, 2 usage, 3 a wrong input file, 4 record, "
    "5 fit did not succeed, 130 interrupted."
)


class Verbs(TyperGroup):
    """Group of all verbs, which reports user errors in one line with their exit code."""

    def invoke(self, ctx: Any) -> Any:
        """Run the verb."""
        try:
            refuse_surroundings(os.environ)
            _refuse_empty(ctx.args)
            with protect_read_files():
                return super().invoke(ctx)
        except MechidError as error:
            raise _report_error(str(error), error.exit_code) from error
        except OSError as error:
            if error.errno != errno.ENAMETOOLONG:
                raise
            raise _report_error(f"{error.filename}: the name is too long for a file; give another", USAGE) from error
        except MemoryError as error:
            raise _report_error(NO_MEMORY, USAGE) from error
        except KeyboardInterrupt as error:
            say_interrupted()
            raise typer.Exit(INTERRUPTED) from error


app = typer.Typer(
    name="mechid",
    cls=Verbs,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    epilog=EPILOG,
)
FIRST = (demo, look, new, check)
VERBS = (
    *FIRST,
    emission,
    simulate,
    identify,
    report,
    explore,
    diagnose,
    compare,
    fleet,
    profile,
    bootstrap,
    design,
    budget,
    quiet,
    export,
    kernel,
)
for verb in VERBS:
    app.command()(verb)
# The function is not called `open`, which would shadow the builtin.
app.command("open")(open_index)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"mechid {version('mechid')}")
        raise typer.Exit


@app.callback()
def mechid(
    shows_version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit."),
    ] = False,
) -> None:
    """Identify a stepper-driven pointing mechanism from torque-transducer records."""
    del shows_version


def main() -> None:
    """Run the command line; never returns."""
    # With Python's default of 700, collections add half a second to the imports.
    gc.set_threshold(COLLECTED)
    prepare_streams()
    warnings.showwarning = _warn
    try:
        try:
            app()
        finally:
            # Flushed here, since errors during the shutdown of Python cannot be handled.
            sys.stdout.flush()
    except ReaderGoneError:
        sys.exit(NOBODY_READS)
    except MechidError as error:
        _say(f"mechid: error: {error}")
        sys.exit(error.exit_code)
    except Exception as error:
        # A library may have converted the KeyboardInterrupt to another error.
        if is_interrupted():
            say_interrupted()
            sys.exit(INTERRUPTED)
        if os.environ.get(DEBUG) == "1":
            raise
        description = " ".join(f"{type(error).__name__}: {error}".split())
        _say(f"mechid: unexpected error, please report it (with the traceback that {DEBUG}=1 shows): {description}")
        sys.exit(UNEXPECTED)


def _warn(message: Warning | str, category: type[Warning], *where: object, **more: object) -> None:
    """Print a warning of mechid in one line; warnings of libraries are for developers."""
    del where, more
    if category is UserWarning:
        _say(f"warning: {message}")


def _refuse_empty(words: Sequence[str]) -> None:
    """Refuse empty arguments; as a folder, an empty name would mean the working directory."""
    pairs = pairwise(("the command's first word", *words))
    empty = [before for before, word in pairs if not word] + [w[:-1] for w in words if re.fullmatch("--[^=]+=", w)]
    if empty:
        raise UsageError(f"{empty[0]}: is empty, as of a shell variable without a value; write what is meant")


def _report_error(line: str, code: int) -> typer.Exit:
    """Print an error, and return the exception that ends the command."""
    _say(f"mechid: error: {line}")
    return typer.Exit(code)


def _say(line: str) -> None:
    """Print a line on stderr, with overlong words shortened."""
    typer.echo(LONG_WORD.sub(lambda word: f"{word[0][:LETTERS]}...", " ".join(line.splitlines())), err=True)
