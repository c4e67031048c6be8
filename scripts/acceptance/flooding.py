"""Floods of a console by a watcher, or by somebody without a token; each is a process of its own: flooding.py
NAME HOST PAUSE [AUTHORITY], with the file of the authority over TLS."""

import contextlib
import socket
import ssl
import sys
import time
from typing import Any

from client import REQUESTS, STOP, UPGRADE, WATCH_TOKEN, head, json_of, masked

SOCKET = head("GET /api/v1/socket", "HOST", WATCH_TOKEN, *UPGRADE)
BODY = json_of(STOP.body)
POST = (
    head(
        f"POST {REQUESTS}",
        "HOST",
        WATCH_TOKEN,
        "Content-Type: application/json",
        f"Content-Length: {len(BODY)}",
    )
    + BODY
)
TINY = masked(0x81, b'{"type":"ping","sent_ms":0}')
LARGE = masked(0x81, b'{"type":"ping","sent_ms":' + b" " * 4000 + b"1}")

STOPS = "POSTs of stops"
# What a socket that does not wait says.
WAITS = (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError)

# What each connection of a flood sends first, and then again and again; without both, connections are made
# and closed.
FLOODS: dict[str, tuple[bytes, bytes]] = {
    "pings": (SOCKET, masked(0x89) * 500),
    "pongs": (SOCKET, masked(0x8A) * 500),
    "empty parts of a message": (SOCKET + masked(0x01, b"{"), masked(0x00) * 500),
    "tiny messages": (SOCKET, TINY * 100),
    "large messages": (SOCKET, LARGE * 4),
    "GETs of the status": (b"", head("GET /api/v1/status", "HOST", WATCH_TOKEN) * 10),
    "GETs of the metrics": (b"", head("GET /metrics", "HOST", WATCH_TOKEN) * 10),
    "GETs of the page, without a token": (b"", head("GET /console/main.js", "HOST", None) * 10),
    STOPS: (b"", POST * 10),
    "new connections": (b"", b""),
    "slow heads, without a token": (b"GET / HTTP/1.1\r\nHost:", b""),
    "new sockets": (SOCKET, b""),
    "sockets that read no pictures": (SOCKET + masked(0x81, b'{"type":"video","path":"jpeg"}'), TINY),
}
# How many connections a flood holds, and after how many seconds a connection that only waits is replaced.
CONNECTIONS = {
    "slow heads, without a token": (100, 3.0),
    "new sockets": (20, 0.0),
    "sockets that read no pictures": (16, 60.0),
}


def connect(host: str, tls: ssl.SSLContext | None) -> socket.socket:
    name, port = host.split(":")
    plain = socket.create_connection((name, int(port)), timeout=2)
    return tls.wrap_socket(plain, server_hostname=name) if tls else plain


def flood(name: str, host: str, pause: float, tls: ssl.SSLContext | None = None) -> None:
    """Floods a program until this process is killed, with a pause between two rounds of its connections."""
    first, rounds = FLOODS[name]
    if not first and not rounds:
        while True:
            for _ in range(20):
                # A program that has too many breaks some of them off.
                with contextlib.suppress(OSError):
                    connect(host, tls).close()
            time.sleep(pause)
    begin, again = (data.replace(b"HOST", host.encode()) for data in (first, rounds))
    count, lasts = CONNECTIONS.get(name, (8, 60.0))
    reads = "read no" not in name
    # Each has its socket, what is still to be sent, and when it began.
    connections: dict[int, list[Any]] = {}
    while True:
        is_idle = True
        for slot in range(count):
            try:
                if slot not in connections:
                    new = connect(host, tls)
                    new.sendall(begin)
                    new.setblocking(False)
                    connections[slot] = [new, b"", time.monotonic()]
                    is_idle = False
                held = connections[slot]
                if reads:
                    try:
                        if not held[0].recv(65536):
                            raise ConnectionError
                        is_idle = False
                    except WAITS:
                        pass
                held[1] = held[1] or again
                if held[1]:
                    try:
                        held[1] = held[1][held[0].send(held[1]) :]
                        is_idle = False
                    except WAITS:
                        pass
                elif time.monotonic() - held[2] > lasts:
                    raise ConnectionError
            except OSError:
                if slot in connections:
                    connections.pop(slot)[0].close()
        time.sleep(max(pause, (0.005 if is_idle else 0) if reads else 0.05))


if __name__ == "__main__":
    authority = sys.argv[4] if len(sys.argv) > 4 else None
    context = ssl.create_default_context(cafile=authority) if authority else None
    flood(sys.argv[1], sys.argv[2], float(sys.argv[3]), context)
