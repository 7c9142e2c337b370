"""The films of the studio: those of a folder, uploads, and samples."""

from __future__ import annotations

import contextlib
import os
import secrets
import tempfile
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from motes import ConfigError, FormatError, Frame, SourceError
from motes.core import FRAME_INTERVAL
from motes.video import IMAGE_ENDINGS
from motes_studio.messages import FilmCard
from motes_studio.safety import VIDEO_ENDINGS, Limits, check_ending, check_film, inside, plain_name

DEPTH = 4
"""Folders in folders that are looked into."""
MOST = 1000
"""Films that are listed, and uploads that are kept."""


class Films:
    """The films that may be opened.

    Parameters
    ----------
    folder
        Where a user has them; None for uploads alone.
    uploads
        Where uploads are kept; it is made.
    limits
        Of their size.
    """

    def __init__(self, folder: Path | None, uploads: Path, limits: Limits) -> None:
        self._folder, self._uploads, self._limits = folder, uploads, limits
        uploads.mkdir(parents=True, exist_ok=True)

    def path(self, name: str, *, uploaded: bool) -> Path:
        """Return the path of a film; raise a SourceError if there is none of that name."""
        folder = self._uploads if uploaded else self._folder
        if folder is None:
            raise SourceError("The studio has no folder of films; upload one.")
        return inside(folder, name)

    def listed(self) -> list[FilmCard]:
        """Return the films, those of the folder first."""
        found: list[FilmCard] = []
        for folder, uploaded in ((self._folder, False), (self._uploads, True)):
            if folder is None:
                continue
            for path in _films(folder.resolve(), DEPTH):
                if len(found) == MOST:
                    return found
                name = path.relative_to(folder.resolve()).as_posix()
                size = path.stat().st_size if path.is_file() else 0
                found.append(FilmCard(name, size, uploaded))
        return found

    def sample(self, name: str) -> FilmCard:
        """Return a film of `motes demo` among the uploads, rendered when it is first asked for."""
        from motes import VideoWriter, synthetic

        films: dict[str, Callable[[], Iterable[tuple[Frame, Any]]]]
        films = {"beetle": synthetic.demo, "street": synthetic.Street, "player": synthetic.Pitch}
        if name not in films:
            raise ConfigError(f"There is no sample film {name!r}; take one of {', '.join(films)}.")
        path = self._uploads / f"sample-{name}.mp4"
        if not path.exists():
            with tempfile.TemporaryDirectory(prefix=".", dir=self._uploads) as folder:
                made = Path(folder) / path.name
                try:
                    with VideoWriter(made, 1 / FRAME_INTERVAL) as writer:
                        for frame, _ in films[name]():
                            writer.write(frame.pixels, frame.time)
                except FormatError as error:  # it names what is left, of which nothing is
                    why = str(error).replace(str(made), path.name)
                    raise FormatError(why.partition(" What there is")[0]) from None
                made.replace(path)
        return FilmCard(path.name, path.stat().st_size, uploaded=True)

    async def upload(self, name: str, size: int | None, parts: AsyncIterator[bytes]) -> FilmCard:
        """Write a film that arrives in parts, and return it; an interrupted one leaves nothing.

        Raises
        ------
        ConfigError
            If it has no name.
        FormatError
            If it is too large, or cannot be written.
        SourceError
            If it is no plain film, or is not called like one.
        """
        plain = plain_name(name)
        check_ending(plain)
        path = self._uploads / plain
        while path.exists():
            path = path.with_name(f"{Path(plain).stem}-{secrets.token_hex(3)}{path.suffix}")
        sizes = [each.stat().st_size for each in self._uploads.iterdir() if each.is_file()]
        if len(sizes) >= MOST:
            raise FormatError(f"{MOST:,} films were sent already; put it into the folder instead.")
        room = min(self._limits.upload, self._limits.uploads - sum(sizes))
        if size is not None and size > room:
            raise _too_large(plain, room)
        partial = path.with_name(f".{secrets.token_hex(8)}{path.suffix}")
        written = 0
        try:
            with partial.open("xb") as file:
                async for part in parts:
                    written += len(part)
                    if written > room:
                        raise _too_large(plain, room)
                    file.write(part)
            check_film(partial)
            partial.replace(path)
        except OSError as error:
            raise FormatError(f"{plain} cannot be written: {error.strerror}.") from None
        except SourceError as error:
            raise SourceError(str(error).replace(partial.name, plain)) from None
        finally:
            partial.unlink(missing_ok=True)
        return FilmCard(path.name, written, uploaded=True)


def _too_large(name: str, room: int) -> FormatError:
    return FormatError(
        f"{name} is larger than {room >> 20} MB, the room that is left; put it into the folder of "
        f"the studio instead."
    )


def _films(folder: Path, depth: int) -> Iterator[Path]:
    """Yield films, folders of images, and animations under a folder; no links."""
    folders: list[Path] = []
    images: list[Path] = []
    with contextlib.suppress(OSError):
        for entry in sorted(os.scandir(folder), key=lambda each: each.name):
            if entry.name.startswith("."):
                continue
            path = Path(entry.path)
            if entry.is_dir(follow_symlinks=False):
                folders.append(path)
            elif entry.is_file(follow_symlinks=False):
                ending = path.suffix.lower()
                if ending in IMAGE_ENDINGS:
                    images.append(path)
                elif ending in VIDEO_ENDINGS and _is_film(path):
                    yield path
    if len(images) > 1:
        yield folder
    elif images and _is_animated(images[0]):
        yield images[0]
    if depth:
        for each in folders:
            yield from _films(each, depth - 1)


def _is_film(path: Path) -> bool:
    """Return whether a file may be opened; a playlist may not."""
    try:
        check_film(path)
    except (SourceError, OSError):
        return False
    return True


def _is_animated(path: Path) -> bool:
    """Return whether an image file has several pictures."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            return bool(getattr(image, "is_animated", False))  # without a walk to the last one
    except Exception:  # a damaged image may raise any, and the list is of all films
        return False
