"""The interface of families of networks: one reads all files of a kind."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.onnx_session import Session
from motes.core.registry import Registry
from motes.core.types import Singles
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
