"""A trained network that learns a target from one region, and looks for it around a place.

Networks are of families: one reads all files of a kind.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import ClassVar, Self

import msgspec
import numpy as np

from motes.core.config import Config, Count
from motes.core.errors import ConfigError, SourceError
from motes.core.frame import Frame, as_frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.log import LOG
from motes.core.onnx_session import Session
from motes.core.registry import Registry
from motes.core.types import Singles
from motes.sot.network.published import paths_of
from motes.sot.network.view import NetworkView


class NetworkFamily:
    """Networks of one kind: what goes into them, and what comes out.

    It is also a `Config` with a tag. All methods are pure.
    """

    __slots__ = ()

    known_as: ClassVar[str]
    """Its files in words, for the error about files of no family."""
    open_sizes: ClassVar[bool] = False
    """Whether a file takes pictures of other sizes than the one it fixes."""

    @abstractmethod
    def arranged(self, files: Sequence[Session]) -> tuple[Session, ...] | None:
        """Return the files in the order of its methods; None if they are of another kind."""

    @abstractmethod
    def learn(self, sessions: Sequence[Session], frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the template of the target in an ellipse of a frame."""

    @abstractmethod
    def look(
        self, sessions: Sequence[Session], template: Singles, frame: Frame, place: Ellipse
    ) -> NetworkView:
        """Return what the network sees around a place."""


FAMILIES = Registry[type[NetworkFamily]](
    "family of networks",
    "motes.networks",
    NetworkFamily,
    {"siamese": "motes.sot.network.siamese:Siamese", "vit": "motes.sot.network.vit:Vit"},
)


KEPT_OPEN = 4
"""Networks that a process keeps open, for all its trackers."""


class Network(Config, frozen=True):
    """A trained network in ONNX files: which ones, and how they are run."""

    files: tuple[str, ...] = ()
    """The files of one network, in any order; to which family they belong is read from them. Or the
    name of one that motes network get has downloaded, such as nanotrack."""
    threads: Count = 1
    """Number of threads."""
    provider: str | None = None
    """What ONNX Runtime runs them on, such as CUDAExecutionProvider; by default the processor."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.files:
            raise ConfigError("files: A network needs its ONNX files; got none")

    @classmethod
    def named(cls, given: str | Sequence[str]) -> Self:
        """Return the network of some files, or of a text that has them with commas between them.

        Raises a ConfigError if a name is empty.
        """
        if isinstance(given, str):
            given = [given] if Path(given).is_file() else given.split(",")
        if not isinstance(given, Sequence) or not all(given):
            raise ConfigError(f"The network is {given!r}; give files, with commas between them.")
        return cls(tuple(given))

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths of its files, also where these are those of a published network.

        Raises a SourceError if they are not on this computer.
        """
        return paths_of(self.files)

    def open(self) -> str:
        """Open the files, try the network on a gray picture, and return its family's name.

        It stays open in this process; the other methods open it too, where that was not done.
        Raises a ConfigError if the files are of no known family, or there is no such provider; a
        SourceError if a file is missing, damaged or too large, or does not run; and a
        MissingDependencyError if ONNX Runtime is not installed.
        """
        return _opened(self).name

    def learn(self, frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the template of the target in an ellipse of a frame; its form is the family's.

        The network sees the upright box of an ellipse. Raises the errors of `open`.
        """
        frame = as_frame(frame)
        opened = _opened(self)
        return opened.family.learn(opened.sessions, frame, as_ellipse(ellipse))

    def look(self, template: Singles, frame: Frame, place: Ellipse) -> NetworkView:
        """Return the boxes that the network sees around a place, and their scores.

        Raises a ConfigError if the place has no area or is not finite. And the errors of `open`.
        `place` is where the target is expected, and its expected size.
        """
        opened = _opened(self)
        return opened.family.look(opened.sessions, template, frame, as_ellipse(place))


class _Opened(msgspec.Struct, frozen=True):
    """A network's family, the family's name, and the files ready to run."""

    name: str
    family: NetworkFamily
    sessions: tuple[Session, ...]


@lru_cache(KEPT_OPEN)
def _opened(network: Network) -> _Opened:
    """Return a network ready to run, tried on a gray picture; raise the errors of `open`."""
    run_on = network.threads, network.provider
    name, family, sessions = _recognized([Session(path, *run_on) for path in network.paths])
    if family.open_sizes:
        sessions = tuple(Session(each.path, *run_on, open_sizes=True) for each in sessions)
    frame, middle = Frame(0, 0.0, np.full((64, 64, 3), 128, np.uint8)), Ellipse(32, 32, 8, 8)
    named = " and ".join(Path(path).name for path in network.paths)
    try:
        view = family.look(sessions, family.learn(sessions, frame, middle), frame, middle)
    except (SourceError, LookupError, ValueError) as error:
        reason = str(error) if isinstance(error, SourceError) else "its outputs have other shapes."
        raise SourceError(
            f"{named}: not the {name} network that they seem to be: {reason}"
        ) from None
    if not view.scores.any():  # as boxes and scores have that are no numbers
        raise SourceError(
            f"{named}: the {name} network gives no box with a score; its weights are damaged. "
            f"Copy or export it again."
        )
    LOG.info("%s: a network of the family %s.", named, name)
    return _Opened(name, family, sessions)


def _recognized(files: Sequence[Session]) -> tuple[str, NetworkFamily, tuple[Session, ...]]:
    """Return the family that files belong to, with its name, and the files in its order."""
    families = {name: kind() for name, kind in FAMILIES.usable().items()}
    for name, family in families.items():
        arranged = family.arranged(files)
        if arranged is not None:
            return name, family, arranged
    known = "; ".join(f"{name}: {family.known_as}" for name, family in families.items())
    given = " and ".join(map(str, files)) or "No file"
    raise ConfigError(f"{given}: no known kind of network. Known are {known}.")
