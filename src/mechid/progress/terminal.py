"""Progress of an identification on stderr: a live line on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.live import Live
from rich.text import Text

from mechid.identification.computation.progress import Progress
from mechid.progress.listening import progress_words

EVERY_S = 5.0
"""Least interval in s between lines that cannot be overwritten, except at a change of stage."""


class ProgressLine:
    """Display of the reports of an identification; used as a context, with `tell` as the listener."""

    def __init__(self, console: Console) -> None:
        self.console = console
        self.latest: Progress | None = None
        self.heard = self.shown = time.perf_counter()
        self.is_shown = True
        self.live: Live | None = None

    def __enter__(self) -> Self:
        if self.console.is_terminal:
            self.live = Live(console=self.console, get_renderable=self._ink, refresh_per_second=4, transient=True)
            self.live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.live is not None:
            self.live.stop()
        self._keep()

    def tell(self, progress: Progress) -> None:
        """Show a report; the last one of each stage remains visible."""
        changed = self.latest is None or progress.stage != self.latest.stage
        if changed:
            self._keep()
        self.latest, self.heard, self.is_shown = progress, time.perf_counter(), False
        if self.live is None and (changed or self.heard - self.shown >= EVERY_S):
            self._keep()

    def _keep(self) -> None:
        """Print the latest report permanently, once."""
        if self.latest is not None and not self.is_shown:
            self.console.print(Text(progress_words(self.latest)), soft_wrap=True)
            self.shown, self.is_shown = time.perf_counter(), True

    def _ink(self) -> Text:
        """Return the live line, whose clock advances between reports."""
        if self.latest is None:
            return Text("starting ...")
        line = progress_words(self.latest, since=time.perf_counter() - self.heard)
        return Text(line, no_wrap=True, overflow="ellipsis")
