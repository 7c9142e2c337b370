"""The films of `motes demo`, for a folder without one: rendered when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from motes.core.errors import ConfigError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.studio.messages import FilmCard


def sample(uploads: Path, name: str) -> FilmCard:
    """Return a sample film among the uploads; it is rendered if it is not there."""
    from motes import synthetic
    from motes.video.writer import VideoWriter

    films: dict[str, Callable[[], Iterable[tuple[Frame, Any]]]]
    films = {"beetle": synthetic.demo, "street": synthetic.Street, "player": synthetic.Pitch}
    if name not in films:
        raise ConfigError(f"There is no sample film {name!r}; take one of {', '.join(films)}.")
    path = uploads / f"sample-{name}.mp4"
    if not path.exists():
        with VideoWriter(path, 1 / FRAME_INTERVAL, overwrite=True) as writer:
            for frame, _ in films[name]():
                writer.write(frame.pixels, frame.time)
    return FilmCard(path.name, path.stat().st_size, uploaded=True)
