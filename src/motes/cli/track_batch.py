"""`motes track` with several objects: a row for each object in each frame."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Sequence

from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import run, summarize
from motes.cli.messages import counted
from motes.cli.moment import Moment, Sink
from motes.core import interrupts
from motes.core.frame import Frame
from motes.core.track import Status
from motes.mot.tracked_object import SceneTrack
from motes.sot.batch import Trackers
from motes.video.sources import Source


def track_several(
    film: Source,
    trackers: Trackers,
    regions: Sequence[Sequence[float]],
    outputs: Sequence[Sink],
) -> int:
    """Track the objects in regions of the first frame; their identities count from 1."""
    tally = Tally(len(regions))

    def moments(frames: Iterator[Frame]) -> Generator[Moment, None, None]:
        for frame in frames:
            clock = time.perf_counter()
            tracks = trackers.update(frame) if trackers.each else trackers.init(frame, regions)
            tally.seconds(time.perf_counter() - clock)
            each = [SceneTrack(i, track) for i, track in enumerate(tracks, start=1)]
            yield Moment(frame, tracks=each, single=False)

    def report(interrupted: KeyboardInterrupt | None) -> None:
        if tally.frames:
            summarize([str(tally)], film, outputs, interrupted)

    interrupted = run(film, outputs, moments, tally.add, report)
    return interrupts.code(interrupted) if interrupted else DONE


class Tally:
    """Statistics of a run with several objects.

    Parameters
    ----------
    objects
        The number of objects.
    """

    def __init__(self, objects: int) -> None:
        self.frames = 0
        self._tracked = [0] * objects
        self._seconds = 0.0

    def seconds(self, seconds: float) -> None:
        """Add the time of a frame; the first one is left out, as it includes the start."""
        self._seconds += seconds if self.frames else 0.0

    def add(self, moment: Moment) -> str:
        """Count a frame; return the state of the run."""
        seen = [each.track.status is Status.TRACKING for each in moment.tracks]
        self.frames += 1
        self._tracked = [count + here for count, here in zip(self._tracked, seen, strict=True)]
        return f"{sum(seen)} of {len(seen)} tracked"

    def __str__(self) -> str:
        parts = [counted(self.frames, "frame")]
        parts += [
            f"object {i} tracked in {100 * count / self.frames:.1f} %"
            for i, count in enumerate(self._tracked, start=1)
        ]
        if self.frames > 1:
            parts.append(f"trackers {1000 * self._seconds / (self.frames - 1):.2f} ms a frame")
        return ", ".join(parts)
