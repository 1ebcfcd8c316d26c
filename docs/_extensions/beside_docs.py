"""What lies beside docs/ in the repository: README and others stand in the site as pages, scripts as text."""

import re
from pathlib import Path

from sphinx.application import Sphinx

PAGES = {
    "readme": "README.md",
    "contributing": "CONTRIBUTING.md",
    "changes": "CHANGELOG.md",
    "security": "SECURITY.md",
    "releasing": "RELEASING.md",
}
"""What the site calls them, and their files; in docs/ a short page of that name links to each."""
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)\s]+)\)")
SCRIPT = re.compile(r"^\[[\w./]+\]\(([\w./]+\.py)\)$", re.MULTILINE)
"""A line that is nothing but a link to a script."""


def seen_from_docs(link: str) -> str:
    """Return a link of a page in the repository's root as a page in docs/ has it."""
    return link.removeprefix("docs/") if link.startswith("docs/") else f"../{link}"


def to_pages(text: str, up: str) -> str:
    """Return a text whose links to such files lead to the site's pages; `up` leads from its folder to docs/."""
    for page, file in PAGES.items():
        text = text.replace(f"]({up}../{file}", f"]({up}{page}.md")
    return text


def read(app: Sphinx, name: str, source: list[str]) -> None:
    """Take such a page from its file, and turn links to them into links within the site."""
    if name in PAGES:
        file = Path(app.srcdir).parent / PAGES[name]
        app.env.note_dependency(file)
        source[0] = LINK.sub(lambda found: f"]({seen_from_docs(found[1])})", file.read_text(encoding="utf-8"))
    source[0] = SCRIPT.sub(r"```{literalinclude} \1\n:language: python\n```", source[0])
    source[0] = to_pages(source[0], "../" * name.count("/"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page as it is read."""
    app.connect("source-read", read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
