"""The configuration of `motes watch`: a scene and its detector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from msgspec.structs import asdict, fields

from motes.core.config import from_dict, merge
from motes.core.detection import Detector, DetectorConfig
from motes.core.errors import ConfigError
from motes.core.registry import Registry
from motes.mot.detection.background import BackgroundConfig
from motes.mot.detection.custom import CustomConfig
from motes.mot.detection.lookalike import LookalikeConfig, LookalikeDetector
from motes.mot.detection.onnx_detector import OnnxConfig, onnx_values
from motes.mot.detection.pretrained import FacesConfig, PeopleConfig, RecordedConfig
from motes.mot.scene_config import SceneConfig, scene_config

DETECTORS = Registry[type[DetectorConfig]](
    "detector",
    "motes.detectors",
    DetectorConfig,
    {
        "background": BackgroundConfig,
        "people": PeopleConfig,
        "faces": FacesConfig,
        "recorded": RecordedConfig,
        "like": LookalikeConfig,
        "callable": CustomConfig,
        "onnx": OnnxConfig,
    },
)


class WatchConfig(SceneConfig, frozen=True):
    """A scene, and the detector of its objects."""

    detector: DetectorConfig = BackgroundConfig()
    """The detector of objects, and its settings."""

    @classmethod
    def of(cls, preset: str) -> Self:
        """Return a preset of the trackers with a background; raise as `scene_config` does."""
        return cls(**asdict(scene_config(preset)))

    def changed(self, changes: Mapping[str, Any], *, detector: str | None = None) -> Self:
        """Return the configuration with changes laid over it.

        Raises a ConfigError for an unknown detector or key, or a value that does not fit; and a
        SourceError if the TOML file beside an ONNX file cannot be read.

        Parameters
        ----------
        changes
            Plain nested values, as in TOML.
        detector
            The name of a detector in place of this one, with its default settings.
        """
        values = merge(self.to_dict(), changes)
        if detector is not None:
            values = merge(values, {"detector": detector_values(detector)})
        config: Self = from_dict(values, type(self))
        return config


def detector_values(name: str | None) -> dict[str, Any]:
    """Return the values of a `DetectorConfig` for a detector's name; None means a background.

    Raises a ConfigError if no detector has that name, or the TOML file beside an ONNX file is not
    valid; and a SourceError if the latter cannot be read.
    """
    if name is None:
        return {"type": "background"}
    if name.endswith(".txt"):
        return {"type": "recorded", "file": name}
    if name.endswith(".onnx"):
        return onnx_values(name)
    if all(name.partition(":")):
        return {"type": "callable", "name": name}
    if name in DETECTORS and _chosen_by_name(DETECTORS.resolve(name)):
        return {"type": name}
    known = ", ".join(name for name, kind in DETECTORS.usable().items() if _chosen_by_name(kind))
    raise ConfigError(
        f"A detector is {known}, MODULE:CALLABLE, or an .onnx or .txt file; got {name!r}."
    )


def _chosen_by_name(kind: Any) -> bool:
    """Return whether a detector is chosen by its name alone."""
    return not any(field.required for field in fields(kind))


def check_code(detector: str | None, allowed: bool) -> None:
    """Raise a ConfigError if a file names a detector that is code, unless that is allowed."""
    if detector is None or allowed or detector.endswith((".txt", ".onnx")):
        return
    if all(detector.partition(":")):
        raise ConfigError(
            f"The detector {detector} is code, which would run; if you trust it, add --own-code."
        )


def named_detector(name: str | None) -> Detector:
    """Return a detector by its name, with default settings; raise a ConfigError for no name."""
    config: DetectorConfig = from_dict(detector_values(name), DetectorConfig)
    return config.detector()


def lookalike_detector(config: LookalikeConfig, detector: str | None) -> LookalikeDetector:
    """Return the detector of what looks like a target, of what moves or what a detector finds.

    Raises a ConfigError if no detector has that name.
    """
    return LookalikeDetector(config, None if detector is None else named_detector(detector))
