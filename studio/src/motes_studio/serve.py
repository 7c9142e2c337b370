"""Runs the studio until it is interrupted, with few connections, and none that is silent."""

from __future__ import annotations

import asyncio
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path

import h11
import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from motes import ConfigError
from motes.core import used_alone
from motes_studio.protocol import LARGEST_MESSAGE
from motes_studio.safety import LOCAL, Guard, Limits, address_of, new_token
from motes_studio.server import app
from motes_studio.store import data_folder
from motes_studio.studio import Studio

HEAD = 10.0
"""Seconds within which the head of a request must be complete."""
CONNECTIONS = 128
"""Connections that are open at once; more are closed unread. A page needs up to seven."""


class Connection(H11Protocol):
    """A connection that is closed if it brings no request in time."""

    _late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for the head of a request, unless too many are open."""
        super().connection_made(transport)
        if len(self.connections) > CONNECTIONS:
            transport.abort()
        else:
            self._late = self.loop.call_later(HEAD, transport.abort)

    def data_received(self, data: bytes) -> None:
        """Take data; whatever comes, the time for a head is counted from its first byte."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._in_time()
        elif self._late is None:
            self._late = self.loop.call_later(HEAD, self.transport.abort)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._in_time()
        super().connection_lost(exc)

    def _in_time(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None


def serve(
    folder: Path | None,
    host: str,
    port: int,
    data: Path | None,
    *,
    log: Callable[[str], None],
    browser: bool,
    limits: Limits,
) -> None:
    """Serve the films of a folder until interrupted; port 0 is any free one.

    Sessions and uploads are kept in `data`, by default the user's folder for data. `log` takes a
    line for the user, for whom a `browser` may be opened.

    Raises
    ------
    ConfigError
        If the address cannot be used.
    FormatError
        If another studio uses the data.
    """
    data = data or data_folder()

    def taken(address: str) -> str:
        where = f", at {address}," * bool(address)
        return f"Another motes studio uses {data}; use that one{where} or give another --data."

    with used_alone(data, taken) as lock, listening(host, port) as opened:
        port = opened.getsockname()[1]
        token = None if host in LOCAL else new_token()
        studio = Studio(folder, data, limits)
        address = address_of(host, port)
        lock.write(address.encode())  # without the token, which is for nobody else
        address += f"?token={token}" if token else ""
        server = uvicorn.Server(settings(app(studio, Guard(host, token))))
        # It takes signals from here on: an interrupt while its loop is made would be a traceback.
        with server.capture_signals():
            log(f"The studio is at {address} ; Ctrl-C ends it.")
            if browser:
                webbrowser.open(address)
            server.run(sockets=[opened])


def settings(application: ASGIApp) -> uvicorn.Config:
    """Return how an application is served."""
    return uvicorn.Config(
        application,
        log_level="error",
        http=Connection,
        ws="websockets-sansio",
        ws_max_size=4 * LARGEST_MESSAGE,  # up to there, the page gets a message
        server_header=False,
        timeout_graceful_shutdown=1,
    )


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens at an address; raise a ConfigError if it cannot be used."""
    if not host:  # which would stand for all addresses
        raise ConfigError("The host is empty; give this computer's name, or 127.0.0.1.")
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        # With the protocol, asyncio sends small answers at once (TCP_NODELAY).
        opened = socket.socket(found[0], socket.SOCK_STREAM, socket.IPPROTO_TCP)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind(found[4])
        opened.listen()
    except OSError as error:
        raise ConfigError(
            f"{host}:{port} cannot be used: {error.strerror}; choose another --port or --host."
        ) from None
    return opened
