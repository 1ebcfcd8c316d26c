"""Server of the page: Bokeh on the loopback interface, for requests from its own pages only."""

from __future__ import annotations

import gc
import logging
import os
import secrets
import socket
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any
from urllib.parse import unquote, urlsplit

from bokeh.protocol.exceptions import ProtocolError
from bokeh.resources import Resources
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.views.static_handler import StaticHandler
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import ErrorHandler, OutputTransform

from mechid.errors import DEBUG, UsageError
from mechid.web.equations import Equations
from mechid.web.session import Source
from mechid.web.tab import Tab

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
SERVED = ("/", "/ws", "/favicon.ico")
FORBIDDEN, MISSING = 403, 404
HEADERS = {
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
SECRET_BYTES = 32
MOST_MESSAGE_BYTES = 1_000_000
UNUSED_MS = 15_000
SAY_MESSAGES = ("bokeh.server.views.ws", "bokeh.server.protocol_handler")
"""Bokeh's loggers that print unreadable messages in full, with a traceback."""
SAYS_REFUSED = "tornado.application"
"""Tornado's logger that prints a traceback for tokens of another run, and for all other faults."""
MOST_SAID = 200


class _Headers(OutputTransform):
    """Adds headers to every response that forbid other pages to frame, read or store it."""

    def transform_first_chunk(self, status_code: int, headers: Any, chunk: bytes, finishing: bool) -> Any:
        for name, value in HEADERS.items():
            headers[name] = value
        return status_code, headers, chunk


class _OneLine(logging.Filter):
    """Shortens log records about a page's message or token to one line; they are not faults of mechid."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Pass every record, shortened unless it reports another fault."""
        if record.name == SAYS_REFUSED:
            if record.exc_info is None or not isinstance(record.exc_info[1], ProtocolError):
                return True
            line = f"a page of another run is not answered ({record.exc_info[1]}): load it again"
        else:
            line = f"the connection of a page: {record.getMessage()}"
        record.msg, record.args, record.exc_info = " ".join(line.split())[:MOST_SAID], (), None
        return True


ONE_LINE = _OneLine()


class LoopbackOnly(BokehTornado):
    """Bokeh application that answers its own pages only.

    A request with another ``Host`` came through a foreign name that resolves to this machine (DNS rebinding). A request
    with another ``Origin``, or marked as cross-site by the browser, was made by another page.
    """

    port: int

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> Any:
        """Return the handler of a request: one of Bokeh's, or a refusal."""
        path = request.path or "/"
        if not self.is_own(request):
            return self.get_handler_delegate(request, ErrorHandler, {"status_code": FORBIDDEN})
        # A null byte in a path raises ValueError in file system calls.
        if "\0" in unquote(path) or (path not in SERVED and not path.startswith("/static/")):
            return self.get_handler_delegate(request, ErrorHandler, {"status_code": MISSING})
        return super().find_handler(request, **kwargs)

    def resources(self, absolute_url: str | bool | None = None) -> Resources:
        """Return the core of BokehJS from this server, regardless of environment variables."""
        del absolute_url
        return Resources(mode="server", root_url="/", components=["bokeh"], path_versioner=StaticHandler.append_version)

    def is_own(self, request: HTTPServerRequest) -> bool:
        """Return whether a request names this server and was not made by a page of another origin."""
        own = {f"{name}:{self.port}" for name in NAMES}
        origin = request.headers.get("Origin")
        # `none` marks an address opened by the user; older browsers do not send the header.
        cross = request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
        # Browsers send no Origin when a user opens an address, so that its absence is accepted.
        return request.host.lower() in own and not cross and (origin is None or _is_http(origin, own))


def _is_http(origin: str, own: set[str]) -> bool:
    parts = urlsplit(origin.lower())
    return parts.scheme == "http" and parts.netloc in own


class Explorer:
    """Server bound to a port of the loopback interface.

    Its web socket accepts only clients with a token that this server signed and sent with a page.

    Parameters
    ----------
    source : Source
    port : int
        Port; 0 takes any free one.

    Raises
    ------
    UsageError
        The port is in use.
    """

    def __init__(self, source: Source, port: int = 0) -> None:
        equations = Equations(source.campaign.mechanism.plant)
        try:
            listening = socket.create_server((LOOPBACK, port))
        except OSError as error:
            raise UsageError(f"port {port}: {error.strerror}; give another, or none for any free one") from error
        # Bound here, so that a port in use is reported before anything is served.
        listening.setblocking(False)
        self.port = int(listening.getsockname()[1])

        tabs: dict[str, Tab] = {}

        def open_tab(document: Any) -> None:
            Tab(source, equations, document, tabs)

        application = LoopbackOnly(
            {"/": open_tab},
            extra_websocket_origins=[f"{name}:{self.port}" for name in NAMES],
            unused_session_lifetime_milliseconds=UNUSED_MS,
            websocket_max_message_size_bytes=MOST_MESSAGE_BYTES,
            sign_sessions=True,
            secret_key=secrets.token_bytes(SECRET_BYTES),
            include_headers=[],
            include_cookies=[],
            transforms=[_Headers],
        )
        application.port = self.port
        http = HTTPServer(application)
        http.add_sockets([listening])
        self.server = BaseServer(IOLoop.current(), application, http)
        if os.environ.get(DEBUG) != "1":
            for name in (*SAY_MESSAGES, SAYS_REFUSED):
                logging.getLogger(name).addFilter(ONE_LINE)

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{LOOPBACK}:{self.port}/"

    def serve(self, *, opens_browser: bool, ready: Callable[[str], None]) -> None:
        """Serve until Ctrl-C or the end of the loop; `ready` receives the address once it answers."""
        self.server.start()
        loop = self.server.io_loop
        loop.add_callback(ready, self.address)
        if opens_browser:
            loop.add_callback(webbrowser.open, self.address)
        try:
            with suppress(KeyboardInterrupt), _quick_collections():
                loop.start()
        finally:
            self.server.unlisten()
            self.server.stop()

    def stop(self) -> None:
        """Stop `serve`, which runs in another thread."""
        self.server.io_loop.add_callback(self.server.io_loop.stop)


@contextmanager
def _quick_collections() -> Iterator[None]:
    """Exclude existing objects from garbage collections."""
    # Bokeh collects twice for each closed tab, and answers no other tab meanwhile.
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
