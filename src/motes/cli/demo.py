"""`motes demo`: three trackers on a rendered video with ground truth."""

from __future__ import annotations

import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from cyclopts import Parameter
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw
from rich.console import Console
from rich.progress import track as progress
from rich.table import Table

from motes import synthetic
from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_counts, prepare_folder
from motes.cli.messages import log
from motes.cli.options import OUTPUT, RUN, Overwrite
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse, iou
from motes.core.interrupts import check, deferred
from motes.core.track import Status
from motes.output.figures import FIGURES, Recorder
from motes.output.overlay import draw, font
from motes.output.track_rows import TrackWriter
from motes.sot.tracker import Tracker
from motes.synthetic.clips import Truth
from motes.video.writer import VideoWriter

Pixels = NDArray[np.uint8]

VIDEOS, ROWS = ("demo.mp4", "track.mp4"), ("default.csv", "nummiaro.csv", "mean_shift.csv")
FILES = (*VIDEOS, "strip.png", *ROWS, "truth.csv", *FIGURES)
MOMENTS = (40, 88, 150, 210)
"""Frames in the strip: before and past the stem, grown, and after the jump."""
STILL = (300, 240)
"""Width and height of a still."""
TRUTH_COLUMNS = "frame,time,x,y,a,b,theta,visible"
HIT = 0.1
"""An estimate that overlaps the truth by less has lost the target."""


def demo(
    *,
    frames: Annotated[int, Parameter(group=RUN)] = 300,
    seed: Annotated[int, Parameter(group=RUN)] = 0,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("demo"),
    overwrite: Overwrite = False,
) -> int:
    """Render a video with ground truth, and compare three trackers on it.

    The trackers are the presets default, nummiaro and mean_shift. The folder gets the video
    (demo.mp4), the tracks drawn (track.mp4, strip.png), a row for each frame (default.csv,
    nummiaro.csv, mean_shift.csv, truth.csv) and the papers' four figures.

    Parameters
    ----------
    frames
        Length of the video in frames; 300 frames show all difficulties.
    seed
        Seed of the scenery and of the particles: 0 or more.
    out
        Folder for the files.
    overwrite
        Whether existing files are replaced.
    """
    if seed < 0:
        raise ConfigError(f"The seed is {seed}; give 0 or more.")
    check_counts(frames=frames)
    clip = synthetic.demo(frames=frames, seed=seed)
    runs = [
        TrackerRun("default", Tracker(seed=seed)),
        TrackerRun("nummiaro", Tracker("nummiaro", seed)),
        TrackerRun("mean shift", Tracker("mean_shift")),
    ]
    _, colors, shift = runs
    recorder = Recorder(colors.tracker.config)
    prepare_folder(out, FILES, overwrite)

    moments = [moment for moment in MOMENTS if moment < frames] or [0]
    truths, strip = [TRUTH_COLUMNS], []
    bar = Console(stderr=True)
    interrupted: KeyboardInterrupt | None = None
    with ExitStack() as stack:
        film, view = (
            stack.enter_context(VideoWriter(out / name, 1 / FRAME_INTERVAL, overwrite))
            for name in VIDEOS
        )
        rows = [stack.enter_context(TrackWriter(out / name, overwrite=overwrite)) for name in ROWS]
        showing = progress(
            clip, "Tracking", len(clip), console=bar, transient=True, disable=not bar.is_terminal
        )
        try:
            for frame, (truth,) in showing:
                check()
                with deferred():
                    for run, row in zip(runs, rows, strict=True):
                        run.step(frame, truth)
                        row.write(frame.index, frame.time, run.tracker.info.track)
                    recorder.add(frame, colors.tracker.info, colors.seconds[-1], shift.seconds[-1])
                    numbers = ",".join(f"{value:.5f}" for value in (*truth.ellipse, truth.visible))
                    truths.append(f"{frame.index},{frame.time:.6f},{numbers}")
                    film.write(frame.pixels)
                    view.write(np.hstack([_panel(frame, truth, run) for run in runs]))
                    if frame.index in moments:
                        strip.append(_still(frame, truth, runs[0]))
        except KeyboardInterrupt as interrupt:
            interrupted = interrupt
    if interrupted is not None and len(truths) == 1:
        return interrupts.code(interrupted)
    recorder.save(out)
    try:
        (out / "truth.csv").write_text("\n".join([*truths, ""]))
        if strip:
            _strip(strip).save(out / "strip.png", optimize=True)
    except OSError as error:
        raise FormatError(f"{out} cannot be written: {error.strerror}; make room there.") from None
    _tell(out, runs)
    if interrupted is None:
        return DONE
    log(f"{interrupts.word(interrupted)}{len(truths) - 1} frames.")
    return interrupts.code(interrupted)


@dataclass
class TrackerRun:
    """A tracker with its results so far."""

    name: str
    tracker: Tracker
    overlaps: list[float] = field(default_factory=list)
    visible: list[float] = field(default_factory=list)
    tracking: list[bool] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def step(self, frame: Frame, truth: Truth) -> None:
        """Track the target in a frame; the first frame starts it on the truth."""
        start = time.perf_counter()
        if self.seconds:
            track = self.tracker.update(frame)
        else:
            track = self.tracker.init(frame, truth.ellipse)
        self.seconds.append(time.perf_counter() - start)
        self.overlaps.append(float(iou(track.box, truth.ellipse.box)))
        self.visible.append(truth.visible)
        self.tracking.append(track.status is Status.TRACKING)


class Score(NamedTuple):
    """The quality of a run.

    Attributes
    ----------
    overlap
        Mean IoU with the truth over the frames in which a part of the target is visible.
    half
        Share of these frames with an IoU above 0.5.
    lost
        First visible frame from which on no visible frame was hit; None if the last one was hit.
    missed, admitted
        Number of frames with an IoU below `HIT`, and of those whose status was not tracking.
    """

    overlap: float
    half: float
    lost: int | None
    missed: int
    admitted: int


def score(overlaps: ArrayLike, visible: ArrayLike, tracking: ArrayLike) -> Score:
    """Score a run from each frame's IoU, visible fraction and whether its status was tracking.

    All have shape (frames,); the target must be visible in some frame.
    """
    overlap, seen = np.asarray(overlaps), np.flatnonzero(np.asarray(visible) > 0)
    hit = overlap >= HIT
    hits = np.flatnonzero(hit[seen])
    after = seen[hits[-1] + 1 :] if hits.size else seen
    return Score(
        overlap=float(overlap[seen].mean()),
        half=float((overlap[seen] > 0.5).mean()),
        lost=int(after[0]) if after.size else None,
        missed=int((~hit).sum()),
        admitted=int((~hit & ~np.asarray(tracking)).sum()),
    )


def _panel(frame: Frame, truth: Truth, run: TrackerRun) -> Pixels:
    """Return the frame with the tracker's particles and estimate, and the truth."""
    info = run.tracker.info
    label = f"{run.name}: {info.track.status} {info.track.confidence:.2f}"
    drawn = draw(
        frame.pixels, info.track, particles=info.ellipses, weights=info.weights, label=label
    )
    image = Image.fromarray(drawn)
    _outline(image, truth.ellipse)
    _note(image, "thin white line: truth", (12, frame.height - 30), 16)
    return np.array(image)


def _still(frame: Frame, truth: Truth, run: TrackerRun) -> Image.Image:
    """Return the part of the frame around the target, with particles and estimate."""
    info = run.tracker.info
    drawn = draw(frame.pixels, info.track, particles=info.ellipses, weights=info.weights, label="")
    (width, height), center = STILL, truth.ellipse[:2]
    left = int(np.clip(center[0] - width / 2, 0, frame.width - width))
    top = int(np.clip(center[1] - height / 2, 0, frame.height - height))
    image = Image.fromarray(drawn).crop((left, top, left + width, top + height))
    _note(image, f"frame {frame.index}: {info.track.status}", (10, 9), 15)
    return image


def _strip(stills: list[Image.Image]) -> Image.Image:
    """Return the stills side by side, with few colors for a small file."""
    strip = Image.fromarray(np.hstack([np.array(still) for still in stills]))
    return strip.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)


def _outline(image: Image.Image, ellipse: Ellipse) -> None:
    points = [tuple(point) for point in ellipse.polygon(90)]
    ImageDraw.Draw(image).polygon(points, outline=(255, 255, 255))


def _note(image: Image.Image, text: str, place: tuple[int, int], size: int) -> None:
    """Write white text on a dark panel."""
    pen, letters = ImageDraw.Draw(image, "RGBA"), font(size)
    left, top, right, bottom = pen.textbbox(place, text, letters)
    pen.rectangle((left - 4, top - 4, right + 4, bottom + 4), (0, 0, 0, 165))
    pen.text(place, text, (255, 255, 255, 255), letters)


def _tell(out: Path, runs: list[TrackerRun]) -> None:
    """Print the scores of the trackers, and the next steps."""
    table = Table("", *(run.name for run in runs))
    scores = [score(run.overlaps, run.visible, run.tracking) for run in runs]
    # A lost tracker may read few pixels: its speed is no merit.
    milliseconds = [
        1000 * float(np.median(np.array(run.seconds)[np.array(run.overlaps) >= HIT]))
        for run in runs
    ]
    for text, cells in (
        ("Mean overlap with the truth (IoU)", [f"{s.overlap:.2f}" for s in scores]),
        ("Frames with IoU > 0.5", [f"{s.half:.0%}" for s in scores]),
        (
            "Lost for good",
            ["never" if s.lost is None else f"from frame {s.lost} on" for s in scores],
        ),
        (
            "Off target (IoU < 0.1) and reported",
            [f"{s.admitted} of {s.missed} frames" for s in scores],
        ),
        ("Time per frame on target, median", [f"{ms:.2f} ms" for ms in milliseconds]),
    ):
        table.add_row(text, *cells)
    console = Console()
    console.print(table)
    for line in (
        f"Look at {out / 'track.mp4'}; the rows, figures and the film alone are beside it.",
        "Next: motes track your_video.mp4 --init x,y,w,h --overlay out.mp4",
    ):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
