"""Who is answered. Truth: the status of raw requests, as a browser of a foreign page or a foreign name would make."""

import gc
import http.client
import logging
import re
import socket
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest
from bokeh.util.token import generate_jwt_token, generate_session_id

from mechid.web.server import SAY_MESSAGES, SAYS_REFUSED

UPGRADE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def answer(address, path="/", headers=()):
    parts = urlsplit(address)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=30)
    connection.request("GET", path, headers=dict(headers))
    response = connection.getresponse()
    content = response.read() if response.status != 101 else b""
    connection.close()
    return response, content


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_its_own_names_are_answered_and_nobody_may_frame_or_keep_the_page(address, name):
    port = urlsplit(address).port
    response, content = answer(address, headers={"Host": f"{name}:{port}", "Origin": f"http://{name}:{port}"})
    assert response.status == 200
    assert b"mechid explore" in content
    assert response.headers["X-Frame-Options"] == "DENY"
    assert response.headers["Cache-Control"] == "no-store"
    assert response.headers["Access-Control-Allow-Origin"] is None


@pytest.mark.parametrize("path", ["/", "/ws", "/static/js/bokeh.min.js"])
@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},  # a foreign name that resolves to this machine
        {"Host": "evil.example:{port}"},
        {"Host": "127.0.0.1"},  # without the port: another server's
        {"Origin": "http://evil.example"},
        {"Origin": "https://127.0.0.1:{port}"},
        {"Origin": "http://127.0.0.1:1"},
        {"Origin": "http://127.0.0.1:{port}.evil.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_other_hosts_and_origins_are_refused(address, path, headers, monkeypatch):
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", "*")  # Bokeh's own setting does not open it
    port = urlsplit(address).port
    sent = {name: value.format(port=port) for name, value in headers.items()}
    response, content = answer(address, path, {**(UPGRADE if path == "/ws" else {}), **sent})
    assert response.status == 403
    assert b"token" not in content


@pytest.mark.parametrize("path", ["/autoload.js", "/metadata", "/nothing", "//evil.example/"])
def test_what_the_page_does_not_need_is_not_there(address, path):
    assert answer(address, path)[0].status == 404


def test_it_listens_on_the_loopback_interface_alone(address):
    port = urlsplit(address).port
    own = {found[4][0] for found in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    others = {ip for ip in own if not ip.startswith("127.")} | {"127.0.0.2"}
    for ip in others:
        with socket.socket() as tried:
            tried.settimeout(5.0)
            assert tried.connect_ex((ip, port)) != 0


def test_the_page_names_no_other_place(address):
    """Truth: no address in it but its own server's, beside names of XML and what scripts are called by."""
    _, content = answer(address)
    found = set(re.findall(rb"(?:src|href)=[\"']([^\"']+)", content))
    assert all(place.startswith((b"/static/", b"static/", b"data:")) for place in found), found


def test_what_was_there_before_is_left_out_of_collections(address):
    """Truth: the interpreter's count. A tab that is forgotten costs two collections, in which no other is answered."""
    answer(address)
    assert gc.get_freeze_count() > 0


@pytest.mark.parametrize(
    "path", ["/%00", "/static/%00", "/static/js/%00bokeh.min.js", "/ws%00", "/static/js/bokeh.min.js%00"]
)
def test_a_path_with_a_zero_is_not_there(address, path):
    assert answer(address, path)[0].status == 404


@contextmanager
def web_socket(address, protocols):
    """Yield the connection after the handshake was asked for."""
    parts = urlsplit(address)
    lines = ["GET /ws HTTP/1.1", f"Host: {parts.netloc}", f"Origin: http://{parts.netloc}"]
    lines += [f"{name}: {value}" for name, value in UPGRADE.items()]
    with socket.create_connection((parts.hostname, parts.port), timeout=30) as asked:
        asked.sendall("\r\n".join([*lines, f"Sec-WebSocket-Protocol: {protocols}", "", ""]).encode())
        yield asked


def opened(address, protocols):
    """Return the first bytes that the web socket sends, after the handshake's headers."""
    content = b""
    with web_socket(address, protocols) as asked:
        while b"\r\n\r\n" not in content or not content.partition(b"\r\n\r\n")[2]:
            more = asked.recv(4096)
            if not more:
                break
            content += more
    return content.partition(b"\r\n\r\n")[2]


def test_the_web_socket_answers_those_alone_that_have_a_token_of_the_page(address):
    """Truth: Bokeh's first message, ACK, and RFC 6455's frame 0x88, with which a server closes."""
    token = re.search(rb'"token":\s*"([^"]+)"', answer(address)[1])[1].decode()
    assert b"ACK" in opened(address, f"bokeh, {token}")
    signed, _, signature = token.rpartition(".")
    made_up = generate_jwt_token(generate_session_id(), signed=False, extra_payload={})
    others = (made_up, signed, f"{signed}.{'A' * len(signature)}")
    for other in others:
        assert opened(address, f"bokeh, {other}")[:1] == b"\x88"


@pytest.fixture
def lines(caplog):
    """Return a function for the lines that the loggers of messages and tokens have said since the test began."""
    loggers = [logging.getLogger(name) for name in (*SAY_MESSAGES, SAYS_REFUSED)]
    for logger in loggers:  # Dask's configuration keeps some of them from the root's handlers
        caplog.set_level(logging.ERROR, logger.name)
        logger.addHandler(caplog.handler)

    def said(beginning):
        records = [record for record in caplog.records if record.getMessage().startswith(beginning)]
        assert all(record.exc_info is None and "\n" not in record.getMessage() for record in records)
        return {record.getMessage() for record in records}

    yield said
    for logger in loggers:
        logger.removeHandler(caplog.handler)


def read_until_closed(asked):
    """Read what the server sends until it closes the connection."""
    while asked.recv(4096):
        pass


def test_a_message_that_cannot_be_read_is_a_line(address, lines):
    """Truth: the log's records; Bokeh's own has a traceback and the whole message."""
    token = re.search(rb'"token":\s*"([^"]+)"', answer(address)[1])[1].decode()
    frame = bytes([0x81, 0x80 | len(b"no json"), 0, 0, 0, 0]) + b"no json"
    with web_socket(address, f"bokeh, {token}") as asked:
        content = b""
        while b"ACK" not in content:  # until then there is nothing that reads messages
            content += asked.recv(4096)
        asked.sendall(3 * frame)  # a message has a header, metadata and a content
        read_until_closed(asked)
    assert lines("the connection of a page: ")


def test_a_page_of_an_earlier_run_is_a_line(address, lines):
    """Truth: the log's records; Tornado's own has a traceback. A tab that stayed open asks with its old token."""
    old = generate_jwt_token(generate_session_id(), signed=False, extra_payload={})
    with web_socket(address, f"bokeh, {old}") as asked:
        read_until_closed(asked)
    assert lines("a page of another run is not answered (Invalid token signature): load it again")
