"""What `motes track` is asked for, when all of it is checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from motes.cli.options import FrameOptions
from motes.cli.track_options import TrackOutputs

if TYPE_CHECKING:
    from motes.mot.analytics.real_units import RealUnits
    from motes.sot.presets import TrackerConfig


@dataclass(frozen=True)
class TrackRequest:
    """A film, its outputs, and how it is tracked.

    Attributes
    ----------
    source, frames
        The film and its frames, as they are given.
    output, outputs
        The file of the rows, - for standard output, or None without rows; and all options of
        outputs.
    config, seed, preset
        The tracker, and the name of its preset.
    units
        How pixels become metres; None for pixels.
    """

    source: str
    frames: FrameOptions
    output: str | None
    outputs: TrackOutputs
    config: TrackerConfig
    seed: int
    preset: str
    units: RealUnits | None
