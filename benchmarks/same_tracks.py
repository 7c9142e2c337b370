"""The tracks of another machine, compared with those of this one.

    python benchmarks/same_tracks.py write tracks.npz        # on one machine
    python benchmarks/same_tracks.py compare tracks.npz      # on the other one

The file holds the pictures too, so that both machines read the same ones.
lab/docs/performance.md has the commands for arm64 under qemu-user.
"""

from __future__ import annotations

import platform
import sys
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from motes import Tracker
from motes.core.types import Bytes, Floats
from motes.cues.sampling import Checkerboard, EveryPixel, Sampling
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import NG_DELP, PRESETS, TrackerConfig
from motes.synthetic.clips import turning

SIZE, FRAMES = (160, 120), 12
NAMES = ("nummiaro", "nummiaro:adaptive", "mean_shift", "maggio", "maggio:printed", "zhao_pei")
PIXELS: dict[str, Sampling] = {
    "all pixels": EveryPixel(),
    "half": Checkerboard(share="half"),
    "quarter": Checkerboard(share="quarter"),
}


def configs() -> dict[str, TrackerConfig]:
    """Return the trackers by name; the background is measured at few places, which is quicker."""
    assert NG_DELP.color is not None
    assert NG_DELP.edges is not None
    found: dict[str, TrackerConfig] = {name: PRESETS[name] for name in (*NAMES, "ng_delp")}
    for name, sampling in PIXELS.items():
        color = replace(NG_DELP.color, sampling=sampling)
        edges = replace(NG_DELP.edges, sampling=sampling)
        found[f"ng_delp, {name}"] = replace(NG_DELP, color=color, edges=edges)
    for name, config in found.items():
        if isinstance(config, ParticleFilter):
            found[name] = replace(config, presence=replace(config.presence, max_positions=1000))
    return found


def tracks(pictures: Bytes, target: tuple[float, ...]) -> dict[str, Floats]:
    """Return the ellipses (frames, 5) of each tracker."""
    found = {}
    for name, config in configs().items():
        tracker = Tracker(config)
        ellipses = [tracker.init(pictures[0], target).ellipse]
        ellipses += [tracker.update(picture).ellipse for picture in pictures[1:]]
        found[name] = np.array(ellipses)
    return found


def write(file: Path) -> None:
    """Write pictures and tracks."""
    clip = turning(SIZE, FRAMES)
    pictures = np.stack([frame.pixels for frame, _ in clip])
    target = np.array(clip[0][1][0].ellipse)
    machine = np.array(platform.machine())
    found = tracks(pictures, tuple(target.tolist()))
    np.savez(file, allow_pickle=False, pictures=pictures, target=target, machine=machine, **found)


def compare(file: Path) -> None:
    """Print the largest difference of each tracker's ellipses, in pixels or radians."""
    with np.load(file) as stored:
        own = tracks(stored["pictures"], tuple(stored["target"].tolist()))
        print(f"{stored['machine']} and {platform.machine()}, {FRAMES} frames:")
        for name, found in own.items():
            print(f"{name:<20}{np.abs(found - stored[name]).max():.2g}")


if __name__ == "__main__":
    {"write": write, "compare": compare}[sys.argv[1]](Path(sys.argv[2]))
