"""Foreign libraries at work on a file: a missing one and a damaged file are the user's one line."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType

from mechid.errors import RecordError
from mechid.reading.process import UnreadableError

EXTRA = "formats"
"""The optional dependencies that the readers of instruments' formats need."""


def import_library(name: str, package: str, label: str) -> ModuleType:
    """Return the module `name` of `package`.

    Raises
    ------
    RecordError
        It is not installed; the message says how to install it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise RecordError(
            f'{label}: reading it needs {package}, which is not installed ({error}); pip install "mechid[{EXTRA}]"'
        ) from error


@contextmanager
def wrap_parser_errors(label: str, kind: str) -> Iterator[None]:
    """Turn whatever a parser raises on a damaged file into a RecordError; its warnings are not for users.

    Parameters
    ----------
    label : str
        What messages call the file.
    kind : str
        The format, as ``"a TDMS file"``.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except RecordError:
        raise
    except UnreadableError as error:
        raise RecordError(f"{label}: is cut off, damaged, or not {kind} ({error}); write or copy it anew") from error
    except MemoryError as error:
        raise RecordError(f"{label}: does not fit into memory; read a part of it with window_s") from error
    except Exception as error:  # parsers of binary formats stumble in every way there is
        what = " ".join(str(error).split())[:160]
        raise RecordError(
            f"{label}: is cut off, damaged, or not {kind} ({type(error).__name__}{': ' if what else ''}{what}); "
            "write or copy it anew"
        ) from error
