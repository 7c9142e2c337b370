"""`motes check`: where rows are doubtful."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import FrameProgress
from motes.cli.input_checks import check_counts, check_not_source, point_out_unfinished
from motes.cli.known_run import TrackerOptions, corrected_run
from motes.cli.load_config import TRACKER_HELP
from motes.cli.option_groups import OUTPUT, FileName, Identity, OutputFile, Overwrite, Whole
from motes.cli.streams import log
from motes.core.errors import FormatError
from motes.core.files import check_writable, write_whole, writing
from motes.core.track import Status, Track
from motes.correction.doubts import Doubt, compare, doubts
from motes.correction.history import History
from motes.correction.passes import run_pass
from motes.correction.rows import KnownRows
from motes.output.contact_sheet import contact_sheet
from motes.output.overlay import png
from motes.video.cuts import cuts_in
from motes.video.film import Film

COUNT = 20
HEAD = ("rank", "frame", "time", "gain", "reasons", "left", "top", "width", "height")

app = App(name="check", help_epilogue=TRACKER_HELP, help_format="plaintext")


@app.default
def check(
    source: FileName,
    rows: Path,
    /,
    *,
    identity: Identity = None,
    count: Annotated[Whole, Parameter(group=OUTPUT)] = COUNT,
    output: OutputFile = None,
    sheet: Annotated[Path | None, Parameter(group=OUTPUT)] = None,
    overwrite: Overwrite = False,
    tracker: TrackerOptions = TrackerOptions(),
) -> int:
    """List the frames of rows whose correction is expected to help most.

    The gain of a frame is the number of frames that its correction is expected to make right. Each
    frame is to be corrected after those before it. Rows of a plain motes track are first compared
    with a pass back from their last row; the options of the configuration are for that.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        A .csv or .jsonl file that motes track, smooth or refine has written.
    count
        Number of frames that are listed.
    output
        List of the frames, .csv.
    sheet
        Contact sheet of the frames, .png.
    """
    check_counts(count=count)
    for path, ending in ((output, ".csv"), (sheet, ".png")):
        if path is not None:
            if path.suffix.lower() != ending:
                raise FormatError(f"{path} does not end in {ending}; rename it.")
            check_writable(path, overwrite)
    for name in (source, str(rows)):
        check_not_source(name, output, sheet)
    table, film, history = corrected_run(source, rows, tracker, identity)
    point_out_unfinished(rows, History.beside(rows))
    tracks = table.tracks if table.hindsight else _compared(film, table, history)
    cuts = cuts_in(film.forward(tracks[0].frame, tracks[-1].frame))
    found = doubts(tracks, history.keys, count, cuts)
    by_frame = {track.frame: track for track in tracks}
    # Files come first: a reader of the list, such as `head`, may end it early.
    if output is not None:
        with writing(output):
            write_whole(output, _table(found, by_frame).encode())
    if sheet is not None and found:
        with writing(sheet):
            write_whole(sheet, _sheet(film, found, by_frame))
    for rank, doubt in enumerate(found, 1):
        print(f"{rank:>3}  frame {doubt.frame:<7} gain {doubt.gain:6.1f}  {_why(doubt)}")
    if not found and not history.unfinished:
        log("No frame is in doubt.")
    if not found and sheet is not None:
        log(f"{sheet} is not written: no frame is listed.")
    written = [str(path) for path in (output, sheet if found else None) if path is not None]
    if written:
        log(f"wrote {', '.join(written)}.")
    return DONE


def _compared(film: Film, table: KnownRows, history: History) -> list[Track]:
    """Return the rows, those up to the last tracked one judged by a pass back from there."""
    places = [
        i
        for i, track in enumerate(table.tracks)
        if track.status is Status.TRACKING  # with a center where a tracker may begin
        and 0 <= track.ellipse.x < film.width
        and 0 <= track.ellipse.y < film.height
    ]
    if not places:
        return list(table.tracks)
    first, last = places[0], places[-1]
    part = table.tracks[first : last + 1]
    table.check_whole()
    with FrameProgress(len(part)) as progress:
        frames = film.backward(part[-1].frame, part[0].frame)
        back = run_pass(
            history.tracker, history.seed, frames, part[-1].ellipse, backward=True,
            observe=lambda _: progress.count("backward"),
        )  # fmt: skip
    judged = compare(part, back)
    return [*table.tracks[:first], *judged, *table.tracks[last + 1 :]]


def _why(doubt: Doubt) -> str:
    return ", ".join(doubt.reasons)


def _table(found: Sequence[Doubt], tracks: dict[int, Track]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEAD)
    for rank, doubt in enumerate(found, 1):
        track = tracks[doubt.frame]
        box = (f"{value:.2f}" for value in track.box)
        writer.writerow(
            [rank, doubt.frame, f"{track.time:.6f}", f"{doubt.gain:.2f}", _why(doubt), *box]
        )
    return text.getvalue()


def _sheet(film: Film, found: Sequence[Doubt], tracks: dict[int, Track]) -> bytes:
    def pictures() -> Iterator[tuple[object, Track, str]]:
        for rank, doubt in enumerate(found, 1):
            text = f"{rank}. frame {doubt.frame}, gain {doubt.gain:.1f}\n{_why(doubt)}"
            yield film.frame(doubt.frame).pixels, tracks[doubt.frame], text

    return png(contact_sheet(pictures()))  # type: ignore[arg-type]
