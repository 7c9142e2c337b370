"""Addresses, and how they may be shown to others."""

from __future__ import annotations

from urllib.parse import SplitResult, urlsplit

from motes.core.errors import ConfigError


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
