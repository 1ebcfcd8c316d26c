"""The branches that mechid takes in the reading process: they are brought back with each answer."""

from fuzz import branches
from mechid.errors import MechidError

branches.watch()  # before the readers are imported there
_told: set[str] = set()


def watched(function, *arguments):
    """Call; return the value or what mechid refused, and branches that this process had not taken before.

    What is refused leaves this process as a value: a copy of it for each would take most of the time. Any other error
    has the branches as `branches`, and the copy is thrown away after it.
    """
    try:
        value = function(*arguments)
    except MechidError as error:
        value = error
    except Exception as error:
        error.branches = _new()
        raise
    return value, _new()


def _new() -> tuple[str, ...]:
    new = branches.taken - _told
    _told.update(new)
    return tuple(new)


def watch_the_process_that_reads() -> None:
    """Have readers of libraries' formats called so."""
    from mechid.reading import process
    from mechid.records import isolated_table
    from mechid.structure import formats

    def call(function, *arguments, size=0, libraries=()):
        try:
            value, new = process.call(watched, function, *arguments, size=size, libraries=libraries)
        except Exception as error:
            branches.taken.update(getattr(error, "branches", ()))
            raise
        branches.taken.update(new)
        if isinstance(value, MechidError):
            raise value
        return value

    isolated_table.call = formats.call = call
