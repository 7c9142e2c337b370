"""The scenes of experiments on many objects: detector and preset, and the short or full run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.options import FLAG, RUN
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.core.detection import Detector
    from motes_lab.papers.expected_time import SceneFactory

Full = Annotated[
    bool,
    FLAG,
    Parameter(group=RUN, help="Measure the whole table; without it, a part in under two minutes."),
]
RenderedDetector = Annotated[
    str | None,
    Parameter(
        group=RUN,
        help="Detector: mog2, gaussian, people, faces or one of another package. The default "
        "is that of the table in lab/docs/results.md.",
    ),
]


def scene_factory(
    detector: str | Callable[[], Detector] | None, preset: str, *, lookalikes: bool = False
) -> SceneFactory:
    """Return a function that makes scenes; each has a detector of its own.

    Parameters
    ----------
    detector
        A detector's name as for motes watch, None for a background, or a function that makes one.
    preset
        The preset that tracks each object.
    lookalikes
        Whether the detector finds what looks like one example; see `for_lookalikes`.

    Raises
    ------
    ConfigError
        If there is no such detector or no such preset, or the preset is no particle filter.
    """
    from motes.mot.pipeline_config import for_lookalikes, named_detector
    from motes.mot.scene import Scene
    from motes.mot.scene_config import scene_config

    config = for_lookalikes(scene_config(preset)) if lookalikes else scene_config(preset)
    make = detector if callable(detector) else lambda: named_detector(detector)
    make()  # a wrong name is refused before anything is computed
    return lambda seed: Scene(make(), config, seed)


def rendered_scene_factory(detector: str | None, preset: str) -> SceneFactory:
    """Return a function that makes scenes for rendered clips, as `scene_factory` does.

    Raises
    ------
    ConfigError
        Also for a file of detections, which is of another film.
    """
    if detector is not None and detector.endswith(".txt"):
        raise ConfigError(
            f"--detector is {detector}, and clips are rendered; give a detector that reads frames, "
            f"such as mog2 or gaussian."
        )
    return scene_factory(detector, preset)
