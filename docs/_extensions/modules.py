"""The list of mechid's modules, made from the first lines of their docstrings."""

import ast
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx

import mechid

PLACE = "<!-- modules -->"
PACKAGE = Path(mechid.__file__).parent


def rows() -> Iterator[str]:
    """Yield a row for each module and package below mechid's own, packages in front of what they hold."""
    yield from ("| module | holds |", "|---|---|")
    for path in sorted(PACKAGE.rglob("*.py"), key=lambda path: (path.parent.parts, path.stem != "__init__", path.stem)):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")
        if name not in ("__init__", "__main__"):
            text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
            first = text.partition("\n")[0].replace("|", r"\|")
            shown = f"**`{name}`**" if path.stem == "__init__" else f"`{name}`"
            yield f"| {shown} | {first} |"


def listed(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the list where a page asks for it."""
    if PLACE in source[0]:
        source[0] = source[0].replace(PLACE, "\n".join(rows()))


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page as it is read."""
    app.connect("source-read", listed)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
