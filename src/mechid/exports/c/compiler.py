"""C compiler of this machine, and compilation of exported sources."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

FLAGS = ("-std=c99", "-O2")
KNOWN = ("cc", "gcc", "clang")


class CompilerError(Exception):
    """Failed compilation; the message is the first error of the compiler."""


def find_compiler() -> str | None:
    """Return the C compiler: the environment variable CC, or the first known one on the path; None if there is none."""
    named = os.environ.get("CC")
    return next((path for name in ([named] if named else KNOWN) if (path := shutil.which(name))), None)


def compile_sources(sources: Sequence[Path], program: Path, *, flags: Sequence[str] = ()) -> Path:
    """Compile sources to a program, or to a library with ``-shared`` among the flags.

    Raises
    ------
    CompilerError
        There is no compiler, or the compilation failed.
    """
    compiler = find_compiler()
    if compiler is None:
        raise CompilerError("no C compiler was found; install one, or name it in CC")
    command = [compiler, *FLAGS, *flags, *map(str, sources), "-o", str(program), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(f"{compiler}: {error}") from error
    if done.returncode:
        # The first line with an error is the cause; later ones are often consequences.
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        raise CompilerError(f"{compiler}: {lines[0] if lines else f'ended with {done.returncode}'}")
    return program
