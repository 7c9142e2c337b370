"""Long films in parts: between keyframes, stretches do not depend on each other.

A part goes from one keyframe to a later one, and its rows are those that the whole film would have
there. Its worker decodes from the film's last key picture before it. What `motes watch` does at a
frame depends on all frames before it, so it has no such parts.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from msgspec.structs import replace

from motes.cluster.jobs import Job
from motes.cluster.records import place_of, read_record
from motes.cluster.store import Store, open_store
from motes.core.errors import SourceError
from motes.correction.history import History, history_path, line_count
from motes.correction.keyframes import Keyframes, keyframes_of


def marks_of(part: Job) -> Keyframes:
    """Return the keyframes of a part."""
    assert part.keyframes is not None
    found = keyframes_of(part.keyframes, part.source)
    return {frame: mark for frame, mark in found.items() if _uses(part, frame)}


def _uses(job: Job, frame: int) -> bool:
    return job.start <= frame and (job.end is None or frame < job.end)


def parts_of(job: Job) -> list[Job]:
    """Return the parts of a job, of `job.split` frames or more each; one is no part."""
    if not job.split or job.keyframes is None or job.do != "track" or "://" in job.keyframes:
        return []
    marks = keyframes_of(job.keyframes, job.source)
    if not all(_uses(job, frame) for frame in marks):
        return []  # the whole job fails, as the command does
    marked = [frame for frame, mark in marks.items() if mark is not None]
    cuts = [job.start]
    for frame in marked[:-1]:  # behind the last keyframe there is no other side
        if frame - cuts[-1] >= job.split:
            cuts.append(frame)
    ends = [*(cut + 1 for cut in cuts[1:]), job.end]
    parts = [
        replace(job, name=f"{job.name} part {n}", start=start, end=end, split=0, is_part=True)
        for n, (start, end) in enumerate(zip(cuts, ends, strict=True))
    ]
    return parts if len(parts) > 1 else []


def join_parts(job: Job, rows: Path) -> None:
    """Write the rows of a job, and their history, from those of its parts.

    Raises
    ------
    SourceError
        If a part has failed.
    """
    assert job.parts_in is not None
    store, histories = open_store(job.parts_in), list[History]()
    with rows.open("wb") as file:
        for part in parts_of(job):
            file.writelines(_rows(store, part, first=not histories))
            history = rows.with_name("part.json")
            history.write_bytes(_result(store, part, history_path(rows).name))
            histories.append(History.load(history))
            history.unlink()
    first, last = histories[0], histories[-1]
    marks = dict(mark for each in histories for command in each.corrections for mark in command)
    whole = replace(last, start=first.start, corrections=[[*marks.items()]])
    whole.save(history_path(rows), line_count(rows))


def _rows(store: Store, part: Job, *, first: bool) -> Iterator[bytes]:
    """Yield the rows of a part; the head and the frame that it shares are the first one's."""
    record = read_record(store, part.name)
    if record is None or record.status != "done":
        why = "is missing" if record is None else f"failed: {record.error}"
        raise SourceError(f"{part.name} {why}")
    lines = store.lines(place_of(part.name, "rows.csv"))
    for number, line in enumerate(lines):
        if first or number > 1:
            yield line


def _result(store: Store, part: Job, file: str) -> bytes:
    name = place_of(part.name, file)
    return store.read([name])[name]
