"""A server for one page and one stream of messages into it."""

from __future__ import annotations

import asyncio
import errno
import json
import threading
import time
from typing import Any, TypeVar

from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketHandler

from ...exceptions import OutputError, ParameterError

LOOPBACK = "127.0.0.1"
PORT = 7000
PORTS_TRIED = 100

Served = TypeVar("Served", bound="LiveServer")


class LiveServer:
    """Serves a page and sends messages to every browser that shows it; one that comes late gets all of them.

    A browser can send nothing back. The server runs in a thread of its own until `close`, or to the end of a `with`
    block.

    Attributes:
        host: Address it listens on.
        port: Port it listens on.
    """

    def __init__(self, page: str, *, host: str = LOOPBACK, port: int = PORT) -> None:
        """Start to serve.

        Args:
            page: The HTML page.
            host: Address to listen on; anything but loopback shows the page to the network.
            port: Port to listen on; if it is taken, the next one that is not. 0 for any.

        Raises:
            ParameterError: If `host` is empty, which would mean every address, or `port` is no port.
            OutputError: If the address cannot be listened on.
        """
        if not host.strip():
            raise ParameterError(f"host must be an address such as {LOOPBACK}, got {host!r}")
        if not 0 <= port <= 65535:
            raise ParameterError(f"port must be 0 to 65535, got {port}")
        self.host = host
        self._sockets = _listen(host, port)
        self.port: int = self._sockets[0].getsockname()[1]
        self._messages: list[str] = []
        self._viewers: set[WebSocketHandler] = set()
        self._connected = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._serve, args=(page,), name="live view", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/"

    def wait_for_viewer(self, timeout: float | None = None) -> bool:
        """Wait until a browser shows the page, at most `timeout` seconds; tell whether one does."""
        # Short waits, so that an interrupt from the keyboard is noticed everywhere.
        waited = 0.0
        while timeout is None or waited < timeout:
            if self._connected.wait(0.1):
                return True
            waited += 0.1
        return self._connected.is_set()

    def send(self, message: dict[str, Any]) -> None:
        """Send a message, plain data, to every browser."""
        self._loop.call_soon_threadsafe(self._send, json.dumps(message, allow_nan=False, separators=(",", ":")))

    def restart(self) -> None:
        """Make every browser, and those that come late, forget the messages so far."""
        self._loop.call_soon_threadsafe(self._forget)

    def close(self) -> None:
        """Stop to serve and free the port."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()

    def __enter__(self: Served) -> Served:
        """Return the server itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop to serve."""
        self.close()

    def _serve(self, page: str) -> None:
        asyncio.set_event_loop(self._loop)
        application = Application([("/", _Page, {"page": page}), ("/stream", _Stream, {"server": self})])
        http = HTTPServer(application)
        http.add_sockets(self._sockets)
        try:
            self._loop.run_forever()
        finally:
            http.stop()
            self._loop.run_until_complete(http.close_all_connections())
            self._loop.close()

    def _send(self, text: str) -> None:
        self._messages.append(text)
        for viewer in self._viewers:
            viewer.write_message(text)

    def _forget(self) -> None:
        self._messages.clear()
        self._send('{"restart":true}')

    def _join(self, viewer: WebSocketHandler) -> None:
        for text in self._messages:
            viewer.write_message(text)
        self._viewers.add(viewer)
        self._connected.set()

    def _leave(self, viewer: WebSocketHandler) -> None:
        self._viewers.discard(viewer)


class _Page(RequestHandler):
    def initialize(self, page: str) -> None:
        self.page = page

    def get(self) -> None:
        self.set_header("Cache-Control", "no-store")
        self.finish(self.page)


class _Stream(WebSocketHandler):
    def initialize(self, server: LiveServer) -> None:
        self.server = server

    def open(self, *_: str, **__: str) -> None:
        self.server._join(self)

    def on_message(self, message: str | bytes) -> None:
        """Ignore what a browser says."""

    def on_close(self) -> None:
        self.server._leave(self)


def _listen(host: str, port: int) -> list[Any]:
    ports = [0] if port == 0 else range(port, min(port + PORTS_TRIED, 65536))
    for candidate in ports:
        sockets = _bound(host, candidate)
        if sockets:
            return sockets
    raise OutputError(f"cannot listen on {host}: every port from {ports[0]} to {ports[-1]} is taken")


def _bound(host: str, port: int) -> list[Any]:
    """Return sockets that listen on a port; none if it is taken."""
    try:
        sockets: list[Any] = bind_sockets(port, address=host)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return []
        raise OutputError(f"cannot listen on {host}, port {port}: {error}") from error
    return sockets


def sleep_until(moment: float) -> None:
    """Sleep until `time.perf_counter()` reaches a moment, s; not at all if it has passed."""
    time.sleep(max(0.0, moment - time.perf_counter()))
