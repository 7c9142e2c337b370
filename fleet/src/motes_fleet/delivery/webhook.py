"""A webhook: an HTTP address that each event is posted to."""

from __future__ import annotations

import base64
import http.client
import io
import socket
import time
import urllib.error
import urllib.request
from collections.abc import Sequence
from typing import Any
from urllib.parse import unquote, urlsplit

from motes.core import without_password
from motes_fleet.delivery.delivery import DeliveryError

ANSWER = 5.0
"""Seconds of a whole exchange: a server must have answered within."""
LARGEST_ANSWER = 64 << 10
"""Bytes of an answer, with its head; only its status counts."""


class _TooLargeError(OSError):
    """A server sends more than it may."""


class _TimedReader(io.RawIOBase):
    """Reads from a socket, and raises a TimeoutError or a _TooLargeError beyond its limits.

    A timeout of a socket limits each read alone: a peer that sends a byte now and then is never
    late.
    """

    def __init__(self, connected: socket.socket, seconds: float, most: int) -> None:
        self._socket, self._until, self._left = connected, time.monotonic() + seconds, most
        self._file = connected.makefile("rb", buffering=0)

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any, /) -> int | None:
        """Read what is there, or wait for it."""
        seconds = self._until - time.monotonic()
        if seconds <= 0:
            raise TimeoutError
        self._socket.settimeout(seconds)
        count = self._file.readinto(buffer)
        self._left -= count or 0
        if self._left < 0:
            raise _TooLargeError
        return count

    def close(self) -> None:
        """Let go of the socket."""
        self._file.close()
        super().close()


class _TimedAnswer(http.client.HTTPResponse):
    """An answer that ends in time."""

    def __init__(self, sock: socket.socket, *options: Any, **more: Any) -> None:
        super().__init__(sock, *options, **more)
        self.fp.close()
        seconds = sock.gettimeout() or 0.0
        self.fp = io.BufferedReader(_TimedReader(sock, seconds, LARGEST_ANSWER))


class _Http(http.client.HTTPConnection):
    """A connection for one exchange; all of its steps share `ANSWER`."""

    response_class = _TimedAnswer

    def __init__(self, *place: Any, **options: Any) -> None:
        super().__init__(*place, **options)
        self._until = time.monotonic() + ANSWER

    def connect(self) -> None:
        super().connect()
        self.limit()

    def getresponse(self) -> http.client.HTTPResponse:
        self.limit()
        return super().getresponse()

    def limit(self) -> None:
        """Give the next step what is left of the time."""
        seconds = self._until - time.monotonic()
        if seconds <= 0:
            raise TimeoutError
        self.sock.settimeout(seconds)


class _Https(http.client.HTTPSConnection, _Http):
    """The same over TLS, whose handshake shares the time."""

    def connect(self) -> None:
        super().connect()  # by way of `_Http`, before the handshake
        self.limit()


class _Handler(urllib.request.HTTPHandler, urllib.request.HTTPSHandler):
    def http_open(self, request: urllib.request.Request) -> http.client.HTTPResponse:
        return self.do_open(_Http, request)

    def https_open(self, request: urllib.request.Request) -> http.client.HTTPResponse:
        return self.do_open(_Https, request)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Takes a redirection as a failure: a posted message would be dropped on the way."""

    def redirect_request(self, *_: Any) -> None:
        """Return None: no other address is asked."""
        return


class Webhook:
    """Posts each message as JSON; an answer with a status from 200 to 299 confirms it.

    The rest of the answer is thrown away. It must end within `ANSWER` and `LARGEST_ANSWER`. A user
    and a password in the http or https address are sent as basic authentication.
    """

    batch = 1

    def __init__(self, address: str) -> None:
        self.name = without_password(address)
        self._opener = urllib.request.build_opener(_Handler, _NoRedirect)
        self._headers = {"Content-Type": "application/json", "User-Agent": "motes"}
        parts = urlsplit(address)
        if parts.username is not None:
            user = f"{unquote(parts.username)}:{unquote(parts.password or '')}".encode()
            self._headers["Authorization"] = "Basic " + base64.b64encode(user).decode()

    def send(self, bodies: Sequence[str]) -> None:
        """Post messages; raise a DeliveryError if one is not confirmed."""
        for body in bodies:
            request = urllib.request.Request(self.name, body.encode(), self._headers)
            try:
                with self._opener.open(request, timeout=ANSWER) as answer:
                    while answer.read(4096):
                        pass
            except urllib.error.HTTPError as error:
                with error:
                    raise DeliveryError(f"{self.name} answers with status {error.code}.") from error
            except (OSError, http.client.HTTPException) as error:
                raise DeliveryError(f"{self.name} {_what_failed(error)}.") from error

    def close(self) -> None:
        """Do nothing: each message has a connection of its own."""


def _what_failed(error: Exception) -> str:
    """Return what a receiver did that gave no answer."""
    reason = getattr(error, "reason", None) or error
    if isinstance(reason, TimeoutError) and reason.errno is None:
        return f"has not finished its answer in {ANSWER:g} s"
    if isinstance(reason, _TooLargeError):
        return f"answers with more than {LARGEST_ANSWER >> 10} kB"
    text = getattr(reason, "strerror", None) or str(reason) or type(reason).__name__
    return f"cannot be reached: {text}"
