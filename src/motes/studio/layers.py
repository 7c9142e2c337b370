"""The layers of one frame: what a tracker computes there, as the papers' figures show it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.frame import Frame
from motes.core.types import Floats
from motes.cues.base import AdaptableCue
from motes.cues.structure_tensor import Orientation
from motes.output.figures import cue_distances, orientation_of, surface_of
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo
from motes.studio.commands import Layer
from motes.studio.messages import Histograms, Layers, Surface
from motes.studio.overlays import heaviest


def layers_of(
    number: int, config: TrackerConfig, frame: Frame, info: StepInfo, wanted: Sequence[Layer]
) -> Layers:
    """Return layers of an object in a frame; what its tracker does not have is empty.

    Parameters
    ----------
    number
        The object.
    config
        Its tracker.
    frame, info
        The frame, and the tracker's report of it.
    wanted
        The layers.
    """
    found: dict[str, object] = {}
    if "rho" in wanted:
        rho = surface_of(config, frame, info)
        found["rho"] = _surface(rho.x, rho.y, rho.rho)
    if "likelihoods" in wanted:
        found["likelihoods"] = _likelihoods(config, frame, info)
    if "particles" in wanted:
        found["particles"], found["weights"] = heaviest(info)
    if "histograms" in wanted:
        found["histograms"] = {
            name: Histograms(
                _numbers(info.models[name].histogram),
                _numbers(cue.observe(info.models[name], frame, info.track.ellipse)),
            )
            for name, cue in config.cues.items()
            if isinstance(cue, AdaptableCue)
        }
    cue = config.cues.get("orientation")
    if "orientation" in wanted and isinstance(cue, Orientation):
        rotated, spectrum = orientation_of(cue, frame, info.track.ellipse)
        model = info.models["orientation"].histogram
        found["orientation"] = {
            "rotated": _numbers(rotated), "fourier": _numbers(spectrum), "model": _numbers(model),
        }  # fmt: skip
    return Layers(number, frame.index, **found)  # type: ignore[arg-type]


def _likelihoods(config: TrackerConfig, frame: Frame, info: StepInfo) -> dict[str, Surface]:
    """Return the likelihood of each cue, 1 at its highest; of other trackers, the similarity."""
    x, y, distances = cue_distances(config, frame, info)
    names = [*distances]
    table = np.array([distances[name] for name in names])
    if isinstance(config, ParticleFilter):
        logs = config.likelihood.log(names, table)
        values = np.exp(logs - logs.max(axis=1, keepdims=True))
    else:
        values = 1 - table**2
    shape = y.size, x.size
    return {
        name: _surface(x, y, each.reshape(shape)) for name, each in zip(names, values, strict=True)
    }


def _surface(x: Floats, y: Floats, values: Floats) -> Surface:
    rounded = np.round(np.nan_to_num(values), 4).tolist()
    return Surface(np.round(x, 2).tolist(), np.round(y, 2).tolist(), rounded)


def _numbers(values: Floats) -> list[float]:
    numbers: list[float] = np.round(np.asarray(values, np.float64), 5).tolist()
    return numbers
