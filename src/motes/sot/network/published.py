"""Trained networks by name: who publishes their files, and where this computer keeps them.

None comes with motes: `motes network get` downloads them. Digests are those of the files that were
measured, or that their publisher states.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from motes.core.errors import ConfigError, SourceError
from motes.core.files import write_folder, writing

_SIAM = (
    "https://raw.githubusercontent.com/HonglinChu/SiamTrackers/"
    "248663fde6bf7c40190cf10ee396d5662919ecd3/NanoTrack/models/nanotrackv2/"
)
_ZOO = (
    "https://media.githubusercontent.com/media/opencv/opencv_zoo/"
    "fef72f8fa7c52eaf116d3df358d24e6e959ada0e/models/object_tracking_vittrack/"
)


class PublishedFile(NamedTuple):
    """A file, as its publisher has it."""

    url: str
    size: int
    """In bytes."""
    sha256: str

    @property
    def name(self) -> str:
        """The file's name."""
        return self.url.rpartition("/")[2]


class PublishedNetwork(NamedTuple):
    """A network, and what is to be known before its files are downloaded."""

    title: str
    source: str
    """The page of its publisher."""
    license: str
    files: tuple[PublishedFile, ...]

    @property
    def size(self) -> int:
        """The bytes of all files."""
        return sum(file.size for file in self.files)


PUBLISHED = {
    "nanotrack": PublishedNetwork(
        "NanoTrack v2",
        "https://github.com/HonglinChu/SiamTrackers/tree/master/NanoTrack",
        "none is stated for the files; read what the publisher allows before you use them",
        (
            PublishedFile(
                _SIAM + "nanotrack_backbone_sim.onnx",
                1056849,
                "530bdd0cd00f19afab79a863e71ba71e3312395a5dc9151af675082bdaaa2fc4",
            ),
            PublishedFile(
                _SIAM + "nanotrack_head_sim.onnx",
                726198,
                "0d8c0637be849f092cc7236cae02e55c8b9455ebe37ba50601d6115db4247cd9",
            ),
        ),
    ),
    "vittrack": PublishedNetwork(
        "ViTTrack of September 2023",
        "https://github.com/opencv/opencv_zoo/tree/main/models/object_tracking_vittrack",
        "Apache 2.0",
        (
            PublishedFile(
                _ZOO + "object_tracking_vittrack_2023sep.onnx",
                714726,
                "2990f0b7cd44d92afa48cd97db6de7be113fc1d9594fddb74e2725c10478e91d",
            ),
        ),
    ),
}
"""The networks that motes can get, by the names that --network takes."""


def published(name: str) -> PublishedNetwork:
    """Return the network of a name; raise a ConfigError if there is none."""
    if name not in PUBLISHED:
        raise ConfigError(f"There is no network {name!r} to get; known are {', '.join(PUBLISHED)}.")
    return PUBLISHED[name]


def folder_of(name: str) -> Path:
    """Return where a network's files are kept: in the user's folder for caches.

    Raises a RuntimeError if the user has no home folder, as in some containers.
    """
    if sys.platform == "win32":
        caches = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        caches = Path.home() / "Library" / "Caches"
    else:
        caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return caches / "motes" / "networks" / name


def fetch(name: str) -> Path:
    """Download a network's files, and return their folder, which is complete or absent.

    Raises a ConfigError if there is no such network; a SourceError if a file cannot be loaded, or
    is another one by now; and a FormatError if there is no room for them.
    """
    from motes.core.download import download  # brings what speaks with servers

    folder = folder_of(name)
    contents = [(file.name, download(*file)) for file in published(name).files]
    with writing(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_folder(folder, contents)
    return folder


def is_whole(name: str) -> bool:
    """Return whether all files of a network are here, as they were published."""
    return all(path.is_file() and _digest(path) == file.sha256 for path, file in _kept(name))


def paths_of(files: Sequence[str]) -> tuple[str, ...]:
    """Return the files of a network: those that are named, or those kept for a published name.

    Raises a SourceError if those of a published network are not here.
    """
    if len(files) != 1 or files[0] not in PUBLISHED or Path(files[0]).is_file():
        return tuple(files)
    paths = [path for path, _ in _kept(files[0])]
    if not all(path.is_file() for path in paths):
        raise SourceError(
            f"The network {files[0]} is not on this computer; get it with: motes network get "
            f"{files[0]}"
        )
    return tuple(map(str, paths))


def _kept(name: str) -> Iterator[tuple[Path, PublishedFile]]:
    folder = folder_of(name)
    return ((folder / file.name, file) for file in PUBLISHED[name].files)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
