"""The live server as a stranger's socket meets it: whom it answers, whom it drops, how it ends."""

import base64
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from aspect_control.views.replays.scene import server as live
from aspect_control.views.replays.scene.server import LiveServer

PAGE = "<p>the arm</p>"


@pytest.fixture
def server():
    with LiveServer(PAGE, port=0) as served:
        yield served


def connect(server, receive_buffer=None):
    stranger = socket.socket()
    if receive_buffer is not None:
        stranger.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    stranger.settimeout(20.0)
    stranger.connect(("127.0.0.1", server.port))
    return stranger


def request(path="/", **headers):
    lines = [f"GET {path} HTTP/1.1", *(f"{name.replace('_', '-')}: {value}" for name, value in headers.items())]
    return "\r\n".join([*lines, "", ""]).encode()


def handshake(**headers):
    key = base64.b64encode(os.urandom(16)).decode()
    asked = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Key": key, "Sec_WebSocket_Version": 13}
    return request("/stream", **asked, **headers)


def answer(server, sent):
    """The status and the head and body of the answer, as far as they come in one piece."""
    with connect(server) as stranger:
        stranger.sendall(sent)
        received = stranger.recv(65536)
        return int(received.split()[1]), received


OURS = ["127.0.0.1:{port}", "localhost:{port}", "LocalHost:{port}", "[::1]:{port}"]
OTHERS = [
    "evil.example",
    "evil.example:{port}",
    "127.0.0.1",
    "127.0.0.1:{other}",
    "localhost",
    "127.0.0.1.evil.example:{port}",
    "localhost:{port}.evil.example",
    "192.168.0.1:{port}",
    "",
]
KINDS = {"page": (request, 200), "nothing": (lambda **headers: request("/nothing", **headers), 404)}
KINDS["stream"] = (handshake, 101)


def named(pattern, server):
    return pattern.format(port=server.port, other=server.port + 1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("host", OURS)
def test_a_request_that_names_the_server_is_answered(server, kind, host):
    ask, expected = KINDS[kind]
    host = named(host, server)
    assert answer(server, ask(Host=host))[0] == expected
    assert answer(server, ask(Host=host, Origin=f"http://{host}"))[0] == expected


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("host", OTHERS)
def test_a_request_under_another_name_is_refused(server, kind, host):
    ask, _ = KINDS[kind]
    status, said = answer(server, ask(Host=named(host, server)))
    assert status == 403
    assert PAGE.encode() not in said


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("origin", [*(f"http://{other}" for other in OTHERS), "https://localhost:{port}", "null"])
def test_a_request_from_another_site_is_refused(server, kind, origin):
    ask, _ = KINDS[kind]
    headers = {"Host": f"127.0.0.1:{server.port}", "Origin": named(origin, server)}
    status, said = answer(server, ask(**headers))
    assert status == 403
    assert PAGE.encode() not in said


def test_a_request_that_names_nobody_is_refused(server):
    with connect(server) as stranger:
        stranger.sendall(b"GET / HTTP/1.0\r\n\r\n")
        assert PAGE.encode() not in stranger.recv(65536)


def test_a_server_on_every_address_answers_to_addresses_and_to_no_name():
    with LiveServer(PAGE, host="0.0.0.0", port=0) as served:  # noqa: S104
        assert answer(served, request(Host=f"192.168.0.1:{served.port}"))[0] == 200
        assert answer(served, request(Host=f"localhost:{served.port}"))[0] == 200
        assert answer(served, request(Host=f"evil.example:{served.port}"))[0] == 403


def viewer(server, **options):
    stranger = connect(server, **options)
    stranger.sendall(handshake(Host=f"localhost:{server.port}"))
    assert stranger.recv(4096).split()[1] == b"101"
    return stranger


def bytes_until_the_end(stranger):
    received = 0
    try:
        while piece := stranger.recv(1 << 20):
            received += len(piece)
    except ConnectionError:
        pass
    return received


def wait_until(condition, patience=20.0):
    end = time.monotonic() + patience
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    return condition()


def test_a_viewer_that_never_reads_is_dropped_and_takes_up_one_message_at_most(server, monkeypatch):
    monkeypatch.setattr(live, "PATIENCE", 0.5)
    message = {"filling": "x" * 100_000}
    with viewer(server, receive_buffer=4096) as stranger:
        assert wait_until(lambda: len(server._viewers) == 1)
        (kept,) = server._viewers
        largest = 0
        for _ in range(300):
            server.send(message)
            time.sleep(0.001)
            waiting = kept._tcp._write_buffer
            largest = max(largest, 0 if waiting is None else len(waiting))
        assert 0 < largest <= 100_100
        assert wait_until(lambda: not server._viewers)
        assert 0 < bytes_until_the_end(stranger) < 300 * 100_000


def test_a_viewer_that_reads_gets_every_message_beside_one_that_does_not(server):
    with viewer(server, receive_buffer=4096), viewer(server) as reader:
        for number in range(200):
            server.send({"number": number, "filling": "x" * 20_000})
        received = b""
        while b'"number":199' not in received[-30_000:]:
            received += reader.recv(1 << 20)
        assert all(f'"number":{number},'.encode() in received for number in range(200))


def test_a_restart_spares_a_slow_viewer_what_is_over(server):
    with viewer(server) as slow:
        for _ in range(300):
            server.send({"old": "x" * 100_000})
        server.restart()
        server.send({"new": True})
        received = b""
        while b'"new":true' not in received[-4096:]:
            received += slow.recv(1 << 20)
        assert received.count(b'"old"') < 300
        assert received.count(b'"restart":true') == 1


def test_what_is_sent_after_the_end_is_lost_in_silence():
    with LiveServer(PAGE, port=0) as served:
        pass
    served.send({"late": True})
    served.restart()
    served.close()


ENDINGS = {
    "closed": "server.close()",
    "interrupted": "import signal; signal.raise_signal(signal.SIGINT)",
    "left running": "",
    "busy": "[server.send({'frame': 'x' * 50_000}) for _ in range(400)]; server.close()",
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_it_ends_without_a_word_with_viewers_connected(ending):
    code = (
        "import sys, time\n"
        "from aspect_control.views.replays.scene.server import LiveServer\n"
        "try:\n"
        "    server = LiveServer('page', port=0)\n"
        "    print(server.port, flush=True)\n"
        "    while len(server._viewers) < 3:\n"
        "        time.sleep(0.01)\n"
        "    for i in range(100):\n"
        "        server.send({'frame': i, 'filling': 'x' * 20_000})\n"
        "    sys.stdin.readline()\n"
        f"    {ENDINGS[ending] or 'pass'}\n"
        "except KeyboardInterrupt:\n"
        "    server.close()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-X", "dev", "-W", "error", "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:

        class Place:
            port = int(process.stdout.readline())

        gone, stuck, reading = viewer(Place), viewer(Place, receive_buffer=4096), viewer(Place)
        time.sleep(0.2)
        gone.close()
        _, complaints = process.communicate("\n", timeout=20.0)
    finally:
        process.kill()
        for stranger in (stuck, reading):
            stranger.close()
    assert (process.returncode, complaints) == (0, "")
