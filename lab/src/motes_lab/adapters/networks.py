"""OpenCV's trackers that are trained networks; users have the ONNX files and name them.

A name ends with the files, such as cv2:nano=BACKBONE,HEAD.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motes import ConfigError


class Network(NamedTuple):
    """A kind of tracker."""

    title: str
    """The name that its authors gave it."""
    factory: str
    """Its name in cv2, to which `_Params` and `_create` are added."""
    files: dict[str, str]
    """The words for its files, by OpenCV's names of the parameters."""

    @property
    def usage(self) -> str:
        """The files, as the user is asked for them."""
        return ",".join(self.files.values())


NETWORKS = {
    "cv2:nano": Network("NanoTrack", "TrackerNano", {"backbone": "BACKBONE", "neckhead": "HEAD"}),
    "cv2:vit": Network("VitTrack", "TrackerVit", {"net": "NETWORK"}),
}


def is_network(name: str) -> bool:
    """Return whether a name is that of a network, with its files or without."""
    return name.partition("=")[0] in NETWORKS


def network_files(name: str) -> list[Path]:
    """Return the files that a name ends with; none for a tracker that is no network.

    Raises
    ------
    ConfigError
        If there are too few or too many files, or one does not exist.
    """
    if not is_network(name):
        return []
    kind, _, given = name.partition("=")
    network = NETWORKS[kind]
    paths = [Path(part) for part in given.split(",")]
    if len(paths) != len(network.files) or not all(path.is_file() for path in paths):
        count = "an ONNX file" if len(network.files) == 1 else f"{len(network.files)} ONNX files"
        raise ConfigError(f"{kind} needs {count}: {kind}={network.usage}; got {given!r}.")
    return paths


def new_network(cv2: Any, name: str) -> Any:
    """Return a new tracker of OpenCV with the network of a name.

    Raises
    ------
    ConfigError
        If its files are not those of this network, which a first picture shows.
    AttributeError
        If this OpenCV lacks it.
    """
    files = network_files(name)
    network = NETWORKS[name.partition("=")[0]]
    parameters = getattr(cv2, f"{network.factory}_Params")()
    for parameter, file in zip(network.files, files, strict=True):
        setattr(parameters, parameter, str(file))
    try:
        tracker = getattr(cv2, f"{network.factory}_create")(parameters)
        image = np.zeros((64, 64, 3), np.uint8)
        tracker.init(image, (16, 16, 32, 32))
        tracker.update(image)
    except cv2.error:
        named = " or ".join(map(str, files))
        raise ConfigError(
            f"OpenCV {cv2.__version__} cannot use {named}; give {network.usage} of "
            f"{network.title}, as ONNX."
        ) from None
    return tracker
