"""The configuration of `motes watch`: a scene and its detector."""

from __future__ import annotations

from typing import TypeAlias, get_args

from motes.core.config import from_dict
from motes.core.detection import Detector
from motes.core.errors import ConfigError
from motes.mot.detection.background import BackgroundConfig, Method
from motes.mot.detection.lookalike import LookalikeConfig
from motes.mot.detection.pretrained import FacesConfig, PeopleConfig, RecordedConfig
from motes.mot.scene_config import SceneConfig

DetectorConfig: TypeAlias = (
    BackgroundConfig | PeopleConfig | FacesConfig | RecordedConfig | LookalikeConfig
)


class WatchConfig(SceneConfig, frozen=True):
    """A scene, and the detector of its objects.

    Attributes
    ----------
    detector
        The detector of objects, and its settings.
    """

    detector: DetectorConfig = BackgroundConfig()


def detector_values(name: str | None) -> dict[str, str]:
    """Return the values of a `DetectorConfig` for a detector's name; None means a background.

    Raises
    ------
    ConfigError
        If no detector has that name.
    """
    if name is None:
        return {"type": "background"}
    if name in ("people", "faces"):
        return {"type": name}
    if name.endswith(".txt"):
        return {"type": "recorded", "file": name}
    if name not in get_args(Method):
        known = ", ".join(get_args(Method))
        raise ConfigError(f"A detector is {known}, people, faces or a .txt file; got {name!r}.")
    return {"type": "background", "method": name}


def named_detector(name: str | None) -> Detector:
    """Return a detector by its name, with default settings; raise a ConfigError for no name."""
    config: DetectorConfig = from_dict(detector_values(name), DetectorConfig)
    return config.detector()
