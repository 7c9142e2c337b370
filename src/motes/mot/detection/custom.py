"""Detectors of the user's own: a Python callable, by its name."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from motes.core.callables import explain, import_callable
from motes.core.config import Config
from motes.core.detection import Detection, DetectorConfig, abilities, as_detections
from motes.core.errors import ConfigError
from motes.core.frame import Frame


class CustomConfig(DetectorConfig, Config, frozen=True, tag="callable"):
    """A detector of the user's own."""

    name: str
    """`module:callable`, also of a module in the current folder. The callable takes a frame, or it
    takes nothing and returns a detector. `motes.as_detections` has the forms that a detector may
    return."""

    def detector(self) -> CustomDetector:
        """Return the detector; raise a ConfigError if there is none of this name."""
        return CustomDetector(self.name)


class CustomDetector:
    """A detector made of a callable, with all that it has; its errors name it and the frame.

    Raises a ConfigError if it cannot be imported, or cannot be called.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        try:
            self._find = _detector(name, import_callable(name))
        except ConfigError as error:
            raise ConfigError(f"The detector {name}: {error}") from None
        except (Exception, SystemExit) as error:  # importing a module may raise anything
            raise ConfigError(f"The detector {name} cannot be made: {explain(error)}.") from None
        vars(self).update(abilities(self._find))

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return what the callable finds in a frame."""
        try:
            return as_detections(self._find(frame))
        except (Exception, SystemExit) as error:
            raise ConfigError(
                f"The detector {self._name} failed in frame {frame.index}: {explain(error)}"
            ) from error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._find, name)


def _detector(name: str, found: Callable[..., Any]) -> Callable[[Frame], Any]:
    """Return a callable that takes a frame, or what one without arguments makes."""
    try:
        inspect.signature(found).bind()
    except (TypeError, ValueError):  # it needs arguments, or is compiled and has no signature
        return found
    made = found()
    if not callable(made):
        raise ConfigError(f"{name} returns a {type(made).__name__}, which is not a detector.")
    detector: Callable[[Frame], Any] = made
    return detector
