"""What a job of `motes batch` does: the command of its name, called in a worker."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass, field
from pathlib import Path

from motes import Source
from motes.cli import (
    NOT_FOUND,
    ConfigOptions,
    CountingOptions,
    FrameOptions,
    KeyframeOptions,
    ObjectOptions,
    TargetOptions,
    TrackerOptions,
    TrackOutputs,
    WatchOutputs,
    convert,
    refine,
    track,
    watch,
)
from motes.correction import ENDING
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.work import Made


@dataclass(frozen=True, kw_only=True)
class CountedFrames(FrameOptions):
    """The frames that are read, with the sources from which they came."""

    opened: list[Source] = field(default_factory=list)

    def open(self, source: str) -> Source:
        """Return the frames of a source."""
        film = super().open(source)
        self.opened.append(film)
        return film


def make(job: Job, folder: Path, form: str, overlay: bool) -> Made:
    """Write the rows of a job, its events and its annotated video into a folder.

    Parameters
    ----------
    job
        The job, whose files are on this machine.
    folder
        An empty folder.
    form
        The ending of the rows.
    overlay
        Whether there is an annotated video.

    Raises
    ------
    MotesError
        As the command does.
    """
    rows, video = folder / f"rows.{form}", folder / "overlay.mp4" if overlay else None
    frames = CountedFrames(start=job.start, end=job.end, stride=job.stride, fps=job.fps)
    with contextlib.redirect_stderr(io.StringIO()):  # errors are raised, the rest is recorded
        if job.do == "track":
            code = _track(job, rows, video, frames)
        elif job.do == "watch":
            code = _watch(job, rows, video, frames)
        else:
            code = _refine(job, rows)
    if form == "parquet":
        for path in folder.glob(f"*{ENDING}"):  # no command that reads a history reads Parquet
            path.unlink()
    if not frames.opened:
        return _rows(rows), None
    notes = [f"Nothing was ever found by {job.do}."] * (code == NOT_FOUND)
    report = frames.opened[-1].report
    if report.assumption is not None:
        notes.append(report.assumption.capitalize())
    if report.problems:
        notes.append(f"The film has problems: {report.problems}.")
    return len(range(job.start, report.decoded, job.stride)), " ".join(notes) or None


def _track(job: Job, rows: Path, video: Path | None, frames: FrameOptions) -> int:
    init = [",".join(map(repr, region)) for region in job.init]
    return track.track(
        job.source,
        target=TargetOptions(init=init, detect=job.detect),
        keys=KeyframeOptions(keyframes=_path(job.keyframes)),
        frames=frames,
        outputs=TrackOutputs(output=str(rows), overlay=video, label=_label(job, rows)),
        preset=job.preset or "default",
        values=ConfigOptions(config=_path(job.config), seed=job.seed),
        network_files=",".join(job.network) or None,
    )


def _watch(job: Job, rows: Path, video: Path | None, frames: FrameOptions) -> int:
    events = str(rows.with_name("events.jsonl"))
    return watch.watch(
        job.source,
        objects=ObjectOptions(detector=job.detector),
        counting=CountingOptions(places=_path(job.places)),
        frames=frames,
        outputs=WatchOutputs(
            output=str(rows), overlay=video, events=[events], label=_label(job, rows)
        ),
        preset=job.preset or watch.PRESET,
        values=ConfigOptions(config=_path(job.config), seed=job.seed),
    )


def _refine(job: Job, rows: Path) -> int:
    """Correct rows; they keep their form, and become Parquet after that."""
    assert job.rows is not None
    own = job.preset is not None or job.config is not None or job.seed
    goal = rows.with_suffix(Path(job.rows).suffix)
    code = refine.refine(
        job.source,
        Path(job.rows),
        keys=KeyframeOptions(keyframes=_path(job.keyframes)),
        output=goal,
        tracker=TrackerOptions(
            preset=job.preset,
            config=_path(job.config),
            seed=job.seed if own else None,
            fps=job.fps,
        ),
    )
    if goal != rows:
        convert.convert(goal, rows)
        goal.unlink()
    return code


def _rows(path: Path) -> int:
    """Return the number of rows in a file, one for each frame."""
    if path.suffix == ".parquet":
        import pyarrow.parquet

        count: int = pyarrow.parquet.read_metadata(path).num_rows
        return count
    with path.open("rb") as file:
        return sum(1 for _ in file) - 1


def _path(name: str | None) -> Path | None:
    return None if name is None else Path(name)


def _label(job: Job, rows: Path) -> str | None:
    return job.label if rows.suffix == ".parquet" else None
