"""The film of a first visit, rendered when it is first asked for."""

from __future__ import annotations

import secrets
from pathlib import Path

from motes.studio.messages import FilmCard

NAME = "sample.mp4"
FRAMES, RATE = 150, 25.0


def sample(uploads: Path) -> FilmCard:
    """Return the sample film among the uploads; it is rendered if it is not there."""
    from motes.synthetic import demo
    from motes.video.writer import VideoWriter

    path = uploads / NAME
    if not path.exists():
        partial = path.with_name(f".{secrets.token_hex(8)}{path.suffix}")
        try:
            with VideoWriter(partial, RATE) as writer:
                for frame, _ in demo(frames=FRAMES):
                    writer.write(frame.pixels, frame.time)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
    return FilmCard(NAME, path.stat().st_size, uploaded=True)
