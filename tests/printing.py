"""What a console prints, as text, and the tables in it."""

import io

from rich.console import Console


def printed(show, data, width, *, terminal=False, **more):
    stream = io.StringIO()
    console = Console(
        file=stream,
        width=width,
        markup=False,
        highlight=False,
        force_terminal=terminal,
        color_system="standard" if terminal else "auto",
        legacy_windows=False,
        _environ={},
    )
    show(data, console, **more)
    return stream.getvalue()


def tables(text):
    """Return the lines of the tables, which begin with a header and end with an empty line."""
    lines = text.splitlines()
    rules = [i for i, line in enumerate(lines) if line and not line.strip(" -")]
    ends = [next(i for i in range(start, len(lines)) if not lines[i]) for start in rules]
    return [lines[start - 1 : end] for start, end in zip(rules, ends, strict=True)]
