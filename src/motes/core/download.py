"""A file from the web, whose size and digest are known before: it is taken whole, or not at all."""

from __future__ import annotations

import hashlib
import time
from http.client import HTTPException
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

from motes import __version__
from motes.core.errors import SourceError

TIMEOUT = 20.0
"""Seconds to wait for an answer, and for its next piece."""
LONGEST = 600.0
"""Seconds that a file may take."""
PIECE = 1 << 16
"""Bytes that are read at once."""


def download(url: str, size: int, sha256: str) -> bytes:
    """Return the content of a file; not more than `size` bytes are read.

    Raises a SourceError if it cannot be reached, is refused or cut off, or is another file by now.
    `sha256` is its digest in hexadecimal digits.
    """
    name, host = url.rpartition("/")[2], Request(url).host
    try:
        content = _read(url, size + 1)
    except HTTPError as error:
        error.close()
        raise SourceError(
            f"{host} refuses {name}: {error.code} {error.reason}; try later, or look there "
            f"whether it has moved."
        ) from None
    except (OSError, HTTPException) as error:
        reason = error.reason if isinstance(error, URLError) else error
        raise SourceError(
            f"{name} cannot be loaded from {host}: {getattr(reason, 'strerror', None) or reason}; "
            f"check the connection and try again."
        ) from None
    if len(content) < size:
        raise SourceError(f"{name} was cut off after {len(content)} of {size} bytes; try again.")
    if len(content) > size or hashlib.sha256(content).hexdigest() != sha256:
        raise SourceError(
            f"{name} of {host} is another file than the one that motes knows; it was changed, on "
            f"the way or there, and is not kept."
        )
    return content


def _read(url: str, most: int) -> bytes:
    """Return what an address has, up to a number of bytes; raise the errors of urllib."""
    content, end = bytearray(), time.monotonic() + LONGEST
    request = Request(url, headers={"User-Agent": f"motes/{__version__}"})
    with urlopen(request, timeout=TIMEOUT) as answer:
        while piece := answer.read1(min(PIECE, most - len(content))):
            content += piece
            if time.monotonic() > end:
                raise TimeoutError(f"it takes longer than {LONGEST:g} s")
    return bytes(content)
