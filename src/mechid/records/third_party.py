"""Use of third-party libraries: one-line messages for missing libraries and for errors of their parsers."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType

from mechid.errors import RecordError
from mechid.reading.process import UnreadableError

EXTRA = "formats"
"""Name of the extra with the libraries of the readers of instrument formats."""


def import_library(name: str, package: str, label: str) -> ModuleType:
    """Import the module `name` of `package`.

    Raises
    ------
    RecordError
        The package is not installed; the message states how to install it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise RecordError(
            f'{label}: reading it needs {package}, which is not installed ({error}); pip install "mechid[{EXTRA}]"'
        ) from error


@contextmanager
def wrap_parser_errors(label: str, kind: str) -> Iterator[None]:
    """Convert any exception of a parser to a RecordError, and suppress its warnings.

    Parameters
    ----------
    label : str
        Name of the file in messages.
    kind : str
        Format, such as ``"a TDMS file"``.
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
    # Parsers of binary formats do not validate their input: damaged files raise exceptions of any type.
    except Exception as error:
        what = " ".join(str(error).split())[:160]
        raise RecordError(
            f"{label}: is cut off, damaged, or not {kind} ({type(error).__name__}{': ' if what else ''}{what}); "
            "write or copy it anew"
        ) from error
