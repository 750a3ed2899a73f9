"""A server for one page and one stream of messages into it."""

from __future__ import annotations

import asyncio
import errno
import json
import threading
import time
from contextlib import suppress
from ipaddress import ip_address
from typing import Any, TypeVar

from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from ....exceptions import OutputError, ParameterError

LOOPBACK = "127.0.0.1"
LOOPBACK_NAMES = ("localhost", LOOPBACK, "[::1]")
PORT = 7000
PORTS_TRIED = 100

PATIENCE = 5.0
"""How long a viewer may leave a message unread before it is dropped, s."""

LARGEST_REQUEST = 1 << 16
"""Largest request or message that a browser may send, bytes; none is expected."""

Served = TypeVar("Served", bound="LiveServer")


class LiveServer:
    """Serves a page and sends messages to every browser that shows it; one that comes late gets all of them.

    Every viewer is fed at its own pace from the messages that all have in common: one that does not read holds up one
    message, and is dropped after `PATIENCE`. Requests must name the server as their host, and come from its own page if
    they say where from: a page of another site cannot reach it under a name of its own that leads here.

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
        sockets = _listen(host, port)
        self.port: int = sockets[0].getsockname()[1]
        self._messages: list[str] = []
        self._viewers: dict[_Stream, asyncio.Event] = {}
        self._connected = threading.Event()
        self._end = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop
        ready = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(page, sockets, ready), name="live view", daemon=True)
        self._thread.start()
        ready.wait()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{_in_url(self.host)}:{self.port}/"

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
        """Send a message, plain data, to every browser; to none once the server is closed."""
        self._soon(self._add, json.dumps(message, allow_nan=False, separators=(",", ":")))

    def restart(self) -> None:
        """Make every browser, and those that come late, forget the messages so far."""
        self._soon(self._forget)

    def close(self) -> None:
        """Stop to serve and free the port."""
        self._soon(self._end.set)
        self._thread.join()

    def names_us(self, host: str) -> bool:
        """Tell whether the `Host` of a request, or of its origin, is this server.

        By a name of loopback, by the address that it listens on or, if it listens on all of them, by any address: names
        can be made to lead here by whoever owns them, addresses cannot.
        """
        name, _, port = host.lower().rpartition(":")
        if not port.isdecimal():
            name, port = host.lower(), "80"
        if port != str(self.port):
            return False
        return name in (*LOOPBACK_NAMES, _in_url(self.host).lower()) or (_is_every(self.host) and _is_address(name))

    def __enter__(self: Served) -> Served:
        """Return the server itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop to serve."""
        self.close()

    def _soon(self, function: Any, *arguments: Any) -> None:
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function, *arguments)

    def _run(self, page: str, sockets: list[Any], ready: threading.Event) -> None:
        asyncio.run(self._serve(page, sockets, ready))

    async def _serve(self, page: str, sockets: list[Any], ready: threading.Event) -> None:
        self._loop = asyncio.get_running_loop()
        ready.set()
        application = Application(
            [("/", _Page, {"page": page, "server": self}), ("/stream", _Stream, {"server": self})],
            default_handler_class=_Nothing,
            default_handler_args={"server": self},
            log_function=lambda _: None,
            websocket_max_message_size=LARGEST_REQUEST,
        )
        http = HTTPServer(application, max_body_size=LARGEST_REQUEST)
        http.add_sockets(sockets)
        await self._end.wait()
        http.stop()
        viewers = list(self._viewers)
        for viewer in viewers:
            viewer.close(1001, "the server has ended")
            viewer.drop()
            self.leave(viewer)
        await asyncio.gather(*(viewer.feeding for viewer in viewers))
        await http.close_all_connections()

    def _add(self, text: str) -> None:
        self._messages.append(text)
        for news in self._viewers.values():
            news.set()

    def _forget(self) -> None:
        # A new list: a viewer that is behind sees by it that it is to begin again.
        self._messages = []
        self._add('{"restart":true}')

    def join(self, viewer: _Stream) -> None:
        """Begin to feed a viewer."""
        self._viewers[viewer] = news = asyncio.Event()
        viewer.feeding = asyncio.create_task(self._feed(viewer, news))
        self._connected.set()

    def leave(self, viewer: _Stream) -> None:
        """Feed a viewer no more."""
        news = self._viewers.pop(viewer, None)
        if news is not None:
            news.set()

    async def _feed(self, viewer: _Stream, news: asyncio.Event) -> None:
        """Send a viewer the messages so far and then those that come, until it is gone or does not read."""
        messages, count = self._messages, 0
        with suppress(WebSocketClosedError, asyncio.TimeoutError):
            while viewer in self._viewers:
                if messages is not self._messages:
                    messages, count = self._messages, 0
                if count == len(messages):
                    news.clear()
                    await news.wait()
                    continue
                await asyncio.wait_for(viewer.write_message(messages[count]), PATIENCE)
                count += 1
        self._viewers.pop(viewer, None)
        viewer.drop()


class _Handler(RequestHandler):
    """Answers only requests that name the server and come from its page or from no page at all."""

    def initialize(self, server: LiveServer) -> None:
        self.server = server

    def prepare(self) -> None:
        headers = self.request.headers
        origin = headers.get("Origin")
        from_us = origin is None or (origin.startswith("http://") and self.server.names_us(origin[len("http://") :]))
        if not (from_us and self.server.names_us(headers.get("Host", ""))):
            self.set_status(403)
            self.finish("This server only answers under its own address.\n")


class _Page(_Handler):
    def initialize(self, server: LiveServer, page: str = "") -> None:
        super().initialize(server)
        self.page = page

    def get(self) -> None:
        self.set_header("Cache-Control", "no-store")
        self.finish(self.page)


class _Nothing(_Handler):
    def prepare(self) -> None:
        super().prepare()
        if not self._finished:
            self.set_status(404)
            self.finish("There is nothing here.\n")


class _Stream(_Handler, WebSocketHandler):
    feeding: asyncio.Task[None]

    def prepare(self) -> None:
        super().prepare()
        self._tcp = self.request.connection.stream  # type: ignore[union-attr]

    def check_origin(self, origin: str) -> bool:
        """Take what `prepare` has let through."""
        return True

    def open(self, *_: str, **__: str) -> None:
        self.server.join(self)

    def on_message(self, message: str | bytes) -> None:
        """Ignore what a browser says."""

    def on_close(self) -> None:
        self.server.leave(self)

    def drop(self) -> None:
        """End the connection without waiting for the other side."""
        self._tcp.close()


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _is_address(name: str) -> bool:
    try:
        ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _is_every(host: str) -> bool:
    return _is_address(host) and ip_address(host).is_unspecified


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
