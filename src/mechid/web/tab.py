"""Tab as a Bokeh document, which receives requests of the page and sends texts and curves."""

from __future__ import annotations

import json
import math
import secrets
import time
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any

from bokeh.core.properties import String
from bokeh.document import Document
from bokeh.model import DataModel
from bokeh.server.contexts import BokehSessionContext
from jinja2 import Template

from mechid.errors import MechidError, UsageError
from mechid.ink.template import asset, environment, page_style
from mechid.web.diagnosis_content import diagnosed_data
from mechid.web.equations import Equations
from mechid.web.figures import RunFigures, Slot
from mechid.web.fit_content import progress_curves
from mechid.web.page_content import limit_message, page_data, shown_data
from mechid.web.session import MOST_SHOWN, Session, Source
from mechid.web.sweep_figure import SweepFigure

POLL_MS = 200
RELOAD_S = 10.0
"""Time in s for which a fit continues without its page, which may be reloading."""
TOKEN_BYTES = 16
Message = Mapping[str, Any]


PACKAGE = "mechid.web"


@lru_cache(maxsize=1)
def page_template() -> Template:
    """Return the page template, which Bokeh's server fills with escaped content for each tab."""
    templates = environment(PACKAGE)
    own = files(PACKAGE).joinpath("templates")
    templates.globals |= {
        "style": page_style() + own.joinpath("explorer.css").read_text(encoding="utf-8"),
        "script": asset("painted.js") + own.joinpath("explorer.js").read_text(encoding="utf-8"),
    }
    return templates.get_template("explorer.html")


class Wire(DataModel):
    """Messages between page and session as JSON: requests of the page, and its content."""

    asked = String(default="")
    page_state = String(default="")


class Tab:
    """Connection of a session to the document of its page.

    A reloaded page is a new document. It requests the session of the earlier document by its token, with values, undo
    history and fit. Sessions that are not requested in time are dropped.

    Parameters
    ----------
    source : Source
    equations : Equations
    document : Document
    tabs : dict of str to Tab
        Tabs of the server by token. This tab is added, and removed when Bokeh drops its document.
    """

    def __init__(self, source: Source, equations: Equations, document: Document, tabs: dict[str, Tab]) -> None:
        self.session, self.equations, self.document = Session(source), equations, document
        self.token, self.tabs, self.wanted = secrets.token_urlsafe(TOKEN_BYTES), tabs, ""
        self.opened_at, self.closed_at = time.monotonic(), math.inf
        tabs[self.token] = self
        self.wire = Wire(name="wire")
        self.slots = [Slot(k) for k in range(min(MOST_SHOWN, len(self.session.scenes)))]
        sweeps = sum(scene.is_sweep for scene in self.session.scenes.values())
        self.sweep_figures = [SweepFigure(k) for k in range(min(MOST_SHOWN, sweeps))]
        self.course = RunFigures()
        self.seen: tuple[Any, ...] = ()
        self.note, self.answered = "", 0
        self.limited: dict[str, str] = {}
        self.framed: tuple[tuple[str, ...], float] | None = None
        self.pictures: dict[str, Any] = {}
        self.effects: dict[str, Any] = {}
        self.sweeps: dict[str, Any] = {}
        self.explained = ""
        self.built = self.sent_knobs = self.session.state.knobs
        self._build(source)

    def _build(self, source: Source) -> None:
        document = self.document
        roots = {name: root for slot in self.slots for name, root in slot.roots.items()} | self.course.roots
        roots |= {figure.root.name: figure.root for figure in self.sweep_figures}
        self.course.roots["run"].tags = [self.wire]
        for root in roots.values():
            document.add_root(root)
        data = page_data(source.campaign, self.session.state.knobs, self.session.scenes)
        data["diagnosed"] = diagnosed_data(source.diagnosed) if source.diagnosed else None
        document.title = f"{data['title']} · mechid explore"
        document.template = page_template()
        marked = ("orders of the step rate", *(one.name for one in source.campaign.mechanism.named_lines))
        document.template_variables.update(
            data=data,
            slots=len(self.slots),
            sweeps=len(self.sweep_figures),
            synthetic=source.campaign.synthetic,
            marked=", ".join(marked),
        )
        self.wire.on_change("asked", self._receive)
        for slot in self.slots:
            slot.time.on_change("start", self._redraw_zoomed)
            slot.time.on_change("end", self._redraw_zoomed)
        document.add_periodic_callback(self._poll, POLL_MS)
        # Bokeh calls this some time after the page is closed, which allows for a reload.
        document.on_session_destroyed(lambda context: self._drop())
        self.redraw()

    def _receive(self, attribute: str, old: str, new: str) -> None:
        del attribute, old
        message = json.loads(new)
        self.answered, self.note = message.get("number", 0), ""
        file = ""
        try:
            file = self._execute(message)
        except MechidError as error:
            self.note = str(error)
        except (KeyError, TypeError, ValueError):
            self.note = f"the page asks for what is not understood: {new}"
        self.send(file=file)

    def _execute(self, message: Message) -> str:
        """Execute a request and redraw what it changes; return the text of a file to be saved, else an empty string."""
        action = message["do"]
        if action == "save":
            return self.session.mechanism_file()
        if action == "hello":
            self.wanted, self.sent_knobs = str(message.get("tab", "")), self.built
            self._take_over()
            return ""
        self._run_action(message)
        if action not in RESTED:
            # Changes made on this page must not be replaced by an earlier session.
            self.wanted = ""
            self.limited = self._limit_messages(message) if action == "turn" else {}
        if action in REDRAWN:
            self.redraw()
        elif action in DRAGGED:
            self._simulate()
            self._draw_curves()
        elif action in RESTED:
            self._follow()
        return ""

    def _run_action(self, message: Message) -> None:
        action = ACTIONS.get(message["do"])
        if action is None:
            raise UsageError(f"the page asks for {message['do']}, which is unknown")
        action(self.session, message)

    def _limit_messages(self, message: Message) -> dict[str, str]:
        """Return the reason why a knob is not at the requested value, by its name; empty if it is."""
        name = message["name"]
        used = self.session.state.now.values[name]
        words = limit_message(self.session.state.knobs[name], float(message["value"]), used)
        return {name: words} if words else {}

    def _take_over(self) -> None:
        """Take over the session of the page before its reload, once that page is closed."""
        earlier = self.tabs.get(self.wanted)
        if earlier is None or earlier is self:
            self.wanted = ""
            return
        # An open page is another tab of the same browser and keeps its session.
        if not earlier.is_closed:
            return
        self.wanted, self.session = "", earlier.session
        del self.tabs[earlier.token]
        earlier.session = Session(self.session.source)
        self.seen, self.framed, self.explained = (), None, ""
        self.redraw()

    def _drop(self) -> None:
        """Cancel the work for a page that does not return."""
        self.tabs.pop(self.token, None)
        self.session.cancel()

    def _redraw_zoomed(self, attribute: str, old: object, new: object) -> None:
        del attribute, old, new
        if self.framed is not None:
            self._draw_curves()
            self._draw_effects()

    def redraw(self) -> None:
        """Simulate and draw everything that is shown."""
        self._simulate()
        self._frame()
        self._draw_curves()
        self._follow()

    def _follow(self) -> None:
        """Draw the effect of the active knob and the spectrograms, which follow the curves."""
        self.effects = self.session.effects()
        self.sweeps = self.session.sweeps(self.pictures)
        self._draw_effects()
        for figure, (name, sweep) in zip(self.sweep_figures, self.sweeps.items(), strict=False):
            figure.show(sweep, self.session.scenes[name])

    def _simulate(self) -> None:
        self.pictures = self.session.pictures()

    def _frame(self) -> None:
        """Reset the axes if another record or stretch is shown."""
        session = self.session
        if self.framed == (session.shown, session.seconds):
            return
        self.framed = None
        for slot, name in zip(self.slots, session.shown, strict=False):
            slot.frame(self.pictures[name], session.scenes[name])
        self.framed = session.shown, session.seconds

    def _draw_curves(self) -> None:
        compared = self.session.estimate_pictures() if self.session.compares else {}
        for slot, name in zip(self.slots, self.session.shown, strict=False):
            slot.show(self.pictures[name], compared.get(name))

    def _draw_effects(self) -> None:
        for slot, name in zip(self.slots, self.session.shown, strict=False):
            slot.show_effect(self.pictures[name], self.effects[name])

    def send(self, file: str = "") -> None:
        """Send the content of the page."""
        data = shown_data(self.session, self.pictures, self.effects, self.sweeps)
        data |= {"answered": self.answered, "note": self.note, "file": file, "limited": self.limited, "tab": self.token}
        plant = self.session.campaign.mechanism.plant
        if self.equations.plant is not plant:
            self.equations, self.explained = Equations(plant), ""
        if self.explained != self.session.hand:
            self.explained = self.session.hand
            data["equations"] = self.equations.of(self.session.hand)
        # The rows of the page belong to another mechanism and are replaced.
        if self.sent_knobs != self.session.state.knobs:
            data["groups"] = self._rows()
        self.wire.update(page_state=json.dumps(data, allow_nan=False))

    def _rows(self) -> str:
        """Return the rows of knobs, for a mechanism to which a fit has added terms."""
        self.sent_knobs = self.session.state.knobs
        page = page_data(self.session.campaign, self.sent_knobs, self.session.scenes)
        return environment(PACKAGE).get_template("knobs.html").render(data=page)

    def _poll(self) -> None:
        """Show the progress and the result of a fit; cancel the fit of a page that stays closed."""
        if self._stays_closed() and self.session.is_fitting:
            self.session.cancel()
        if self.wanted:
            self._take_over()
            if time.monotonic() - self.opened_at > RELOAD_S:
                # The earlier page is still open, so this is a second tab and not a reload.
                self.wanted = ""
            self.send()
        self.session.follow()
        run = self.session.shown_run
        if run is None:
            return
        ended = self.session.adopt_result()
        state = (id(run), len(run.reports), run.state, int(run.elapsed_s))
        if state == self.seen and not ended:
            return
        self.seen = state
        knobs = self.session.state.knobs
        ratios, places = progress_curves(run.reports, knobs)
        symbols = {name: knob.parameter.declaration.symbol for name, knob in knobs.items()}
        self.course.show(ratios, places, symbols)
        if ended:
            self.redraw()
        self.send()

    def _stays_closed(self) -> bool:
        """Return whether the page has been closed for longer than a reload takes."""
        self.closed_at = min(self.closed_at, time.monotonic()) if self.is_closed else math.inf
        return time.monotonic() - self.closed_at > RELOAD_S

    @property
    def is_closed(self) -> bool:
        """Whether the connection of the page is closed; Bokeh keeps its session for a while."""
        context = self.document.session_context
        session = context.session if isinstance(context, BokehSessionContext) else None
        return session is not None and session.connection_count == 0


Action = Callable[[Session, Message], None]
ACTIONS: Mapping[str, Action] = {
    "turn": lambda session, m: session.turn(m["name"], float(m["value"]), m.get("grip", "")),
    "settle": lambda session, m: None,
    "take": lambda session, m: session.take(m["name"]),
    "free": lambda session, m: session.set_free(m["name"], is_free=bool(m["is"])),
    "switch": lambda session, m: session.switch(m["name"], is_on=bool(m["is"])),
    "undo": lambda session, m: session.undo(),
    "estimate": lambda session, m: session.to_estimate(),
    "file": lambda session, m: session.to_file(),
    "look": lambda session, m: session.look(tuple(m["records"]), float(m["seconds"])),
    "compare": lambda session, m: session.compare(is_on=bool(m["is"])),
    "fit": lambda session, m: session.fit_from_here(),
    "search": lambda session, m: session.search(),
    "cancel": lambda session, m: session.cancel(),
}
DRAGGED = ("turn",)
RESTED = ("settle", "take")
"""Requests that update the effect of a knob and the spectrograms, sent when no knob is moving."""
REDRAWN = ("switch", "undo", "estimate", "file", "look", "compare")
