"""Command lines: verbs, options and files in any combination, run in this process; none gets as far as a search."""

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any
from unittest.mock import patch

from fuzz.draw import Draw
from fuzz.kinds.tomls import SEEDS
from fuzz.trial import Kind, Misread

QUICK = ("check", "report", "compare", "export", "new", "kernel", "look", "design", "budget", "fleet", "diagnose")
REFUSED = (
    "identify",
    "profile",
    "bootstrap",
    "simulate",
    "explore",
    "report",
    "diagnose",
    "design",
    "budget",
    "fleet",
    "compare",
    "export",
)
"""With files that are wrong: with right ones they compute for minutes."""
RIGHT = ("campaign.toml", "mechanism.toml", ".", "full_46.csv", "estimate.json")
WRONG = (
    "nowhere",
    "nowhere.toml",
    "",
    "empty",
    "empty.toml",
    "binary.toml",
    "mechanism.toml",
    "full_46.csv",
    "a\nb",
    "x" * 200,
    "/dev/null",
    "~",
    "..",
    "-",
    "--",
    "ü.toml",
    "pipe",
    "nothing.csv",
    "full_46.csv/x",
)
OPTIONS = (
    "--out",
    "--resume",
    "--help",
    "--version",
    "--unknown",
    "--assembly",
    "--quantity",
    "--unit",
    "--column",
    "--sample-rate-hz",
    "--to",
    "--latex",
    "--source",
    "--workers",
    "--seed",
    "--campaign",
    "--port",
    "--draws",
    "--parameter",
    "--scheduler",
    "--duration-s",
    "-h",
    "--no-browser",
    "--criterion",
    "--total-s",
    "--diagnosis",
)
VALUES = (
    "out",
    "full_46.csv",
    "",
    "-1",
    "0",
    "1e400",
    "nan",
    "torque",
    "N*m",
    "c",
    "linear",
    "tables",
    "D",
    "gear.stiffness",
    "1",
    "9" * 30,
    "brushed_dc_drive",
    "tcp://127.0.0.1:1",
    "x",
)


def write(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write small files of each kind, and a command line."""
    for path in SEEDS.iterdir():
        shutil.copy(path, folder / path.name)
    (folder / "empty").mkdir()
    (folder / "empty.toml").write_text("")
    (folder / "nothing.csv").write_text("")
    (folder / "binary.toml").write_bytes(bytes(range(256)))
    os.mkfifo(folder / "pipe")
    if draw.chance(0.15):  # these compute for a second
        verb, files = draw.choice(("check", "check", "look", "new", "kernel")), RIGHT
    else:
        verb, files = draw.choice(REFUSED), WRONG
    words = [verb, *(draw.choice(files) for _ in range(draw.choice((0, 1, 1, 1, 2))))]
    for _ in range(draw.choice((0, 0, 1, 1, 2, 3))):
        words.append(draw.choice(OPTIONS))
        if draw.chance(0.7):
            words.append(draw.choice(VALUES))
    if draw.chance(0.05):
        words = [draw.text() for _ in range(draw.randrange(4))]
    if draw.chance(0.1):
        draw.shuffle(words)
    if set(words) & {"demo", "explore", "identify", "profile", "bootstrap", "simulate"} and set(words) & {
        ".",
        "campaign.toml",
    }:
        words = ["check", *words]
    return {"words": [word.replace("\0", "") for word in words]}


@contextmanager
def _written(path: Path) -> Iterator[Path]:
    """Have all that this process says written to a file; yield it."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = os.dup(1), os.dup(2)
    file = os.open(path, os.O_WRONLY | os.O_CREAT)
    os.dup2(file, 1)
    os.dup2(file, 2)
    try:
        yield path
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, one in enumerate(kept, 1):
            os.dup2(one, number)
            os.close(one)
        os.close(file)


def _without_end(words: list[str]) -> AbstractContextManager[Any]:
    """Have an explorer, which would serve until Ctrl-C, come up and end."""
    return patch("mechid.web.server.Explorer.serve") if "explore" in words else nullcontext()


def read(folder: Path, written: dict[str, Any]) -> None:
    """Run the command in the folder; its exit code is one that stands in docs/files.md, its error one line."""
    from mechid.cli.app import main

    before, sys.argv, here = sys.argv, ["mechid", *written["words"]], Path.cwd()
    os.environ["MECHID_DEBUG"] = "1"
    os.chdir(folder)
    try:
        with _written(folder / "said.txt") as said, _without_end(written["words"]):
            main()
        code: Any = 0
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.argv = before
        os.chdir(here)
    err = said.read_text(errors="replace")
    lines = [line for line in err.splitlines() if line.startswith("mechid: error")]
    if code not in (0, 2, 3, 4, 5) or "Traceback" in err:
        raise Misread(f"exit code {code}: {written['words']}")
    if len(lines) > 1 or (code in (3, 4, 5) and not lines):
        raise Misread(f"not one line: {written['words']}: {err[-300:]}")
    if code:  # refused
        from mechid.errors import UsageError

        raise UsageError(f"exit code {code}")


COMMANDS = (Kind("command", write, read, codes=(2,), weight=1),)
