"""A block of the user's own: ``block = "file.py:Name"`` in a table of the mechanism file."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from mechid.campaign.own_block_parts import refuse_odd_parts
from mechid.campaign.place import Place, text
from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.reading.whole import read_bytes

REMEDY = 'write the file and the name in it, as block = "my_friction.py:grease"'


def read_own_block(entry: Any, place: Place, folder: Path) -> tuple[Block, str]:
    """Return the block that a Python file makes, and its place written so that any folder finds it.

    Parameters
    ----------
    entry : str
        ``"file.py:Name"``; Name is a `Block`, or a function that returns one.
    place : Place
        Where the entry stands.
    folder : Path
        Folder of the mechanism file, against which the path is taken.

    Raises
    ------
    InputFileError
        There is no such file or name, the file fails, or what it makes is no block.
    """
    path, colon, name = text(entry, place, REMEDY).rpartition(":")
    if not colon or not path.endswith(".py") or not name.isidentifier():
        raise place.error(f'found "{entry}"; {REMEDY}')
    file = (folder / path).resolve()
    module = _module(file, path, place)
    if not hasattr(module, name):
        near = did_you_mean(name, [key for key in vars(module) if not key.startswith("_")]) or "; check the name"
        raise place.error(f'{path} has no "{name}"{near}')
    block = _made(getattr(module, name), f"{path}:{name}", place)
    if not isinstance(block, Block):
        raise place.error(
            f"{path}:{name} gives {type(block).__name__}; it has to be a Block, or a function returning one"
        )
    refuse_odd_parts(block, f"{path}:{name}", place)
    return block, f"{file.as_posix()}:{name}"


def _module(file: Path, path: str, place: Place) -> ModuleType:
    """Run the file as a module of a name of its own; a changed file is run anew."""
    try:
        content = read_bytes(file)
    except FileNotFoundError as error:
        beside = [other.name for other in file.parent.glob("*.py")] if file.parent.is_dir() else []
        near = did_you_mean(file.name, beside) or "; the path begins at the mechanism file's folder"
        raise place.error(f"{path}: there is no such file{near}") from error
    except OSError as error:
        raise place.error(f"{path}: cannot be read ({error.strerror}); {REMEDY}") from error
    name = f"mechid_own_{hashlib.sha256(str(file).encode() + content).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise place.error(f"{path} fails: {_in_a_line(error)}") from error
    sys.modules[name] = module
    return module


def _made(thing: Any, called: str, place: Place) -> Any:
    if not callable(thing):
        return thing
    try:
        return thing()
    except InputFileError:
        raise
    except (Exception, SystemExit) as error:
        raise place.error(f"{called} fails: {_in_a_line(error)}") from error


def _in_a_line(error: BaseException) -> str:
    at = f" (line {error.lineno})" if isinstance(error, SyntaxError) and error.lineno else ""
    return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'no message'}{at}"
