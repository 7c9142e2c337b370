"""A webhook: an HTTP address that each event is posted to."""

from __future__ import annotations

import base64
import http.client
import urllib.error
import urllib.request
from collections.abc import Sequence
from typing import Any
from urllib.parse import unquote, urlsplit

from motes.core.addresses import without_password
from motes.output.delivery import DeliveryError

ANSWER = 5.0
"""Seconds within which a server must answer."""


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Takes a redirection as a failure: a posted message would be dropped on the way."""

    def redirect_request(self, *_: Any) -> None:
        """Return None: no other address is asked."""
        return


class Webhook:
    """Posts each message as JSON; an answer with a status from 200 to 299 confirms it.

    Parameters
    ----------
    address
        An http or https address. A user and a password in it are sent as basic authentication.
    """

    batch = 1

    def __init__(self, address: str) -> None:
        self.name = without_password(address)
        self._opener = urllib.request.build_opener(_NoRedirect)
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
                    answer.read()
            except urllib.error.HTTPError as error:
                with error:
                    raise DeliveryError(f"{self.name} answers with status {error.code}.") from error
            except (OSError, http.client.HTTPException) as error:
                reason = getattr(error, "reason", None) or error
                text = getattr(reason, "strerror", None) or str(reason) or type(reason).__name__
                raise DeliveryError(f"{self.name} cannot be reached: {text}.") from error

    def close(self) -> None:
        """Do nothing: each message has a connection of its own."""
