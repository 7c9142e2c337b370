"""The times of pictures: their stamps, without those that their neighbors contradict."""

from __future__ import annotations

import bisect
import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence

from motes.core.errors import SourceError
from motes.core.frame import FRAME_INTERVAL
from motes.video.report import Load, Report, Stamped

AHEAD = 8
"""Pictures of a recording whose stamps are known before one is judged; up to half as many wrong
ones in a row are found."""
TICK = 1e-6
"""Times closer than this, in seconds, differ only by rounding."""


def timed(
    pictures: Iterable[Stamped],
    fps: float | None,
    report: Report,
    *,
    even: bool = False,
    ahead: int = 0,
) -> Iterator[tuple[float, float | None, Load]]:
    """Yield the time of each picture since the first one, its stamp, and a function that loads it.

    Times strictly increase. Stamps that are missing, do not increase, or are contradicted by those
    around are replaced and counted. If `even`, no stamp counts, and the times are those of the rate
    `fps`. `ahead` is how many further pictures are read before one is yielded; 0 for those that
    come live.
    """
    if fps and even:
        for index, (stamp, load) in enumerate(pictures):
            report.decoded += 1
            report.assumed = False
            yield index / fps, stamp, load
        return
    interval = 1 / fps if fps else FRAME_INTERVAL
    origin, last = None, -interval
    for stamp, load, later in _looking_ahead(pictures, report, ahead):
        before = -math.inf if origin is None else origin + last
        right = stamp is not None and not _contradicted(stamp, before, later, interval)
        if origin is None and right:
            origin = stamp - (last + interval)  # type: ignore[operator]
        moment = math.nan if origin is None or stamp is None else stamp - origin
        if right and moment - last >= TICK:
            report.steps[round((moment - last) / report.UNIT)] += 1
        else:
            report.retimed += 1
            moment = last + min(interval, _room(before, later))
        last = moment
        yield moment, stamp, load


def _looking_ahead(
    pictures: Iterable[Stamped], report: Report, count: int
) -> Iterator[tuple[float | None, Load, list[float]]]:
    """Yield stamp and load of each picture, and the stamps of the next `count` ones.

    An error comes after all pictures that were read before it.
    """
    coming, held = iter(pictures), deque[Stamped]()
    failure: SourceError | None = None
    more = True
    while more or held:
        while more and len(held) <= count:
            try:
                held.append(next(coming))
                report.decoded += 1
            except StopIteration:
                more = False
            except SourceError as error:
                more, failure = False, error
        if held:
            stamp, load = held.popleft()
            yield stamp, load, [each for each, _ in held if each is not None]
    if failure is not None:
        raise failure


def _contradicted(stamp: float, before: float, later: Sequence[float], interval: float) -> bool:
    """Return whether more of the next stamps increase without this one, after the one before.

    Where as many increase without the next one, the two are judged by how even they leave the
    steps.
    """
    without, kept = _increasing(later, before), 1 + _increasing(later, stamp)
    if without != kept or not before < later[0] <= stamp:
        return without > kept
    steps_without, steps_kept = [(later[0] - before) / 2], [stamp - before]
    if len(later) > 1:
        steps_without.append(later[1] - later[0])
        steps_kept.append((later[1] - stamp) / 2)
    uneven, uneven_kept = (
        max(abs(step - interval) for step in steps) for steps in (steps_without, steps_kept)
    )
    return uneven < uneven_kept


def _room(before: float, later: Sequence[float]) -> float:
    """Return the longest step to a replaced stamp after which the next one still increases.

    Where many stamps are wrong, as in AVI, their rate is a better guess.
    """
    reliable = (
        later and later[0] - before >= 2 * TICK and 4 * _increasing(later, before) >= 3 * len(later)
    )
    return (later[0] - before) / 2 if reliable else math.inf


def _increasing(stamps: Sequence[float], above: float) -> int:
    """Return how many stamps above a value increase at most, if others are left out."""
    ends = list[float]()  # the least end of each number of them (patience sorting)
    for stamp in stamps:
        if stamp > above:
            place = bisect.bisect_left(ends, stamp)
            ends[place : place + 1] = [stamp]
    return len(ends)
