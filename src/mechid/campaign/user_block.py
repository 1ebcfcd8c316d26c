"""Loader of user blocks, ``block = "file.py:Name"`` in a table of the mechanism file."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from mechid.campaign.place import Place, text
from mechid.campaign.user_block_checks import refuse_invalid_parts
from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.reading.whole import read_bytes

REMEDY = 'write the file and the name in it, as block = "my_friction.py:grease"'


def read_own_block(entry: Any, place: Place, folder: Path) -> tuple[Block, str]:
    """Load a block from a Python file; return it with its absolute place.

    Parameters
    ----------
    entry : str
        ``"file.py:Name"``; Name is a `Block` or a function that returns one.
    place : Place
        Place of the entry.
    folder : Path
        Folder of the mechanism file, the base of the path.

    Raises
    ------
    InputFileError
        The file or name does not exist, the file fails, or the object is not a block.
    """
    path, colon, name = text(entry, place, REMEDY).rpartition(":")
    if not colon or not path.endswith(".py") or not name.isidentifier():
        raise place.error(f'found "{entry}"; {REMEDY}')
    file = (folder / path).resolve()
    module = _module(file, path, place)
    if not hasattr(module, name):
        near = did_you_mean(name, [key for key in vars(module) if not key.startswith("_")]) or "; check the name"
        raise place.error(f'{path} has no "{name}"{near}')
    block = _call_factory(getattr(module, name), f"{path}:{name}", place)
    if not isinstance(block, Block):
        raise place.error(
            f"{path}:{name} gives {type(block).__name__}; it has to be a Block, or a function returning one"
        )
    refuse_invalid_parts(block, f"{path}:{name}", place)
    return block, f"{file.as_posix()}:{name}"


def _module(file: Path, path: str, place: Place) -> ModuleType:
    """Import the file as a module under a unique name."""
    try:
        content = read_bytes(file)
    except FileNotFoundError as error:
        beside = [other.name for other in file.parent.glob("*.py")] if file.parent.is_dir() else []
        near = did_you_mean(file.name, beside) or "; the path begins at the mechanism file's folder"
        raise place.error(f"{path}: there is no such file{near}") from error
    except OSError as error:
        raise place.error(f"{path}: cannot be read ({error.strerror}); {REMEDY}") from error
    # The content is part of the name, so that a changed file is imported again.
    name = f"mechid_own_{hashlib.sha256(str(file).encode() + content).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    # A path to a .py file always has a spec and a loader.
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise place.error(f"{path} fails: {_one_line(error)}") from error
    sys.modules[name] = module
    return module


def _call_factory(thing: Any, called: str, place: Place) -> Any:
    if not callable(thing):
        return thing
    try:
        return thing()
    # Errors raised by the user block with its own message pass unchanged.
    except InputFileError:
        raise
    except (Exception, SystemExit) as error:
        raise place.error(f"{called} fails: {_one_line(error)}") from error


def _one_line(error: BaseException) -> str:
    at = f" (line {error.lineno})" if isinstance(error, SyntaxError) and error.lineno else ""
    return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'no message'}{at}"
