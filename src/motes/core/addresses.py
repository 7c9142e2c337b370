"""Addresses: as they may be shown to others, and those from which a server is asked."""

from __future__ import annotations

import socket
from urllib.parse import SplitResult, urlsplit

from motes.core.errors import ConfigError

LOCAL = ("localhost", "127.0.0.1", "::1")
"""Names of this computer that no other one reaches."""
EVERYWHERE = ("0.0.0.0", "::")
"""What stands for all addresses of this computer."""


def address_of(host: str, port: int) -> str:
    """Return the address of a server that listens at a host, as a browser opens it."""
    name = socket.gethostname() if host in EVERYWHERE else host
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def parts_of(url: str) -> SplitResult:
    """Return the parts of an address; raise a ConfigError if it is none."""
    try:
        parts = urlsplit(url)
        parts.port  # noqa: B018  (reads it, and fails if it is no number of a port)
    except ValueError as error:
        shown = url.rpartition("@")[2]  # without a password
        raise ConfigError(f"{shown} is no address: {error}; correct it.") from None
    return parts


def without_password(url: str) -> str:
    """Return an address without its user and password, for messages."""
    parts = parts_of(url)
    return parts._replace(netloc=parts.netloc.rpartition("@")[2]).geturl()


def foreign(listening: str, host: str | None, origin: str | None) -> str | None:
    """Return why a request is refused by its headers Host and Origin; None if it is not.

    A page of another address must not act through the browser of somebody who may: neither openly,
    nor under a name of its own that it lets point to this computer.

    Parameters
    ----------
    listening
        The name or number at which the server listens.
    host, origin
        The headers; None if there is none.
    """
    try:
        name = urlsplit(f"//{host or ''}").hostname
        source = None if origin is None else urlsplit(origin).netloc.lower()
    except ValueError:
        return "The Host or Origin of this request is no address."
    if listening in LOCAL and name not in LOCAL:
        return "This address is not that of the server; use the one that it has printed."
    if source is not None and source != (host or "").lower():
        return "A page of another address asks; open the server's own address."
    return None
