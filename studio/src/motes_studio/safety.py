"""What the studio lets through: limits, the token, hosts and origins, and paths of files."""

from __future__ import annotations

import hmac
import os
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from motes import ConfigError, SourceError
from motes.video import IMAGE_ENDINGS, is_playlist

VIDEO_ENDINGS = frozenset({
    ".264", ".265", ".3g2", ".3gp", ".amv", ".apng", ".asf", ".avc", ".avi", ".dav", ".divx",
    ".dv", ".f4v", ".flv", ".gif", ".gxf", ".h264", ".h265", ".hevc", ".ivf", ".m1v", ".m2t",
    ".m2ts", ".m2v", ".m4v", ".mj2", ".mjpeg", ".mjpg", ".mk3d", ".mkv", ".mod", ".mov", ".mp4",
    ".mpe", ".mpeg", ".mpg", ".mpv", ".mts", ".mxf", ".nut", ".obu", ".ogg", ".ogm", ".ogv", ".qt",
    ".rm", ".rmvb", ".tod", ".trp", ".ts", ".vob", ".webm", ".wmv", ".wtv", ".y4m",
})  # fmt: skip
"""Films that are listed. Playlists, which reach elsewhere, are not among them."""
FILM_ENDINGS = VIDEO_ENDINGS | IMAGE_ENDINGS

COOKIE = "motes-studio"
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        "connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of all answers."""

LOCAL = ("localhost", "127.0.0.1", "::1")
"""Names of this computer that no other one reaches."""
EVERYWHERE = ("0.0.0.0", "::")
"""What stands for all addresses of this computer."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What the studio takes at most."""

    upload: int = 8 << 30
    """Bytes of an uploaded film."""
    uploads: int = 64 << 30
    """Bytes of all uploaded films."""
    imported: int = 64 << 20
    """Bytes of a file of tracks."""
    pixels: int = 7680 * 4320
    """Pixels of a frame."""
    frames: int = 1_000_000
    """Frames of a film."""
    sessions: int = 16
    """Sessions that are open at once."""
    jobs: int = 20
    """Jobs that a session has at once."""
    memory: int = 4 << 30
    """Bytes of memory of a worker."""
    silence: float = 60.0
    """Seconds after which a worker that gives no sign is ended."""
    networks: tuple[str, ...] = ()
    """Files of networks that a configuration may name, as they are written there."""


class Guard:
    """Decides which requests are answered.

    Parameters
    ----------
    host
        Where the server listens.
    token
        What a browser must know; None on this computer alone.
    """

    def __init__(self, host: str, token: str | None) -> None:
        self._host, self._token = host, token

    def knows(self, token: str | None) -> bool:
        """Return whether a token is the right one; without one, all are."""
        if self._token is None:
            return True
        return hmac.compare_digest((token or "").encode(), self._token.encode())

    def refusal(self, headers: Mapping[str, str]) -> str | None:
        """Return why a request is refused by its headers Host and Origin; None if it is not.

        A page of another address must not act through the browser of somebody who may: neither
        openly, nor under a name of its own that it lets point to this computer.
        """
        host, origin = headers.get("host", ""), headers.get("origin")
        try:
            name = urlsplit(f"//{host}").hostname
            source = None if origin is None else urlsplit(origin).netloc.lower()
        except ValueError:
            return "The Host or Origin of this request is no address."
        if self._host in LOCAL and name not in LOCAL:
            return "This address is not that of the server; use the one that it has printed."
        if source is not None and source != host.lower():
            return "A page of another address asks; open the server's own address."
        return None


def new_token() -> str:
    """Return a token that cannot be guessed."""
    return secrets.token_urlsafe(24)


def inside(folder: Path, name: str) -> Path:
    """Return the path of a file or a folder of images under a folder.

    Raises
    ------
    SourceError
        If the name leads elsewhere, also by a link, or names no film.
    """
    wrong = SourceError(f"There is no film {name!r} in this folder; choose one of the list.")
    if not name or "\0" in name or Path(name).is_absolute():
        raise wrong
    root = folder.resolve()
    try:
        path = (root / name).resolve(strict=True)
    except (OSError, RuntimeError):
        raise wrong from None
    if not path.is_relative_to(root) or path == root:
        raise wrong
    check_film(path)
    return path


def check_film(path: Path) -> None:
    """Raise a SourceError unless a path is a plain film: a video, an image or images."""
    if path.is_dir():
        with os.scandir(path) as entries:
            for entry in entries:
                image = os.path.splitext(entry.name)[1].lower() in IMAGE_ENDINGS
                if image and not entry.is_file(follow_symlinks=False):
                    raise SourceError(f"{path.name} holds links or devices; give plain images.")
        return
    if not path.is_file():
        raise SourceError(f"{path.name} is no plain file; give a film.")
    check_ending(path.name)
    if is_playlist(path):
        raise SourceError(f"{path.name} is a playlist, which names other files; give the film.")


def check_ending(name: str) -> None:
    """Raise a SourceError unless a file's name ends like that of a film."""
    if Path(name).suffix.lower() not in FILM_ENDINGS:
        raise SourceError(
            f"{name} does not end like a film, as .mp4 or .mkv; rename or convert it."
        )


def plain_name(name: str) -> str:
    """Return the name of a sent file, without folders and what no system takes in a name.

    Raises
    ------
    ConfigError
        If nothing of it is left, or too much.
    """
    plain = "".join(each for each in Path(name).name if each.isprintable() and each not in '/\\:"')
    plain = plain.lstrip(".")
    if not plain.strip(". ") or len(os.fsencode(plain)) > 200:
        raise ConfigError("The name of the file is none, or too long; give a short one.")
    return plain


def address_of(host: str, port: int) -> str:
    """Return the address of a server that listens at a host, as a browser opens it."""
    name = socket.gethostname() if host in EVERYWHERE else host
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"
