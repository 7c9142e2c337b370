"""Playlists and scripts, which FFmpeg reads as films: they name other files or addresses."""

from __future__ import annotations

from pathlib import Path

BEGINNINGS = (b"#EXTM3U", b"ffconcat", b"<?xml", b"<MPD", b"[playlist]")
ENDINGS = (".m3u8", ".m3u", ".mpd", ".pls", ".ffconcat", ".concat", ".txt")
"""How such files begin, and how their names end where they do not pass for a film."""
HEAD = 4096
"""Bytes of a file in which such a beginning is looked for."""


def is_playlist(path: Path) -> bool:
    """Return whether a file begins like one that names others."""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except OSError:  # whoever opens it as a film says why
        return False
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(BEGINNINGS)
