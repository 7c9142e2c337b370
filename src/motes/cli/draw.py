"""`motes draw`: overlay and figures of any rows, whatever has made or changed them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from motes.cli.input_checks import check_not_source, prepare_folder
from motes.cli.known_run import units_of
from motes.cli.options import OUTPUT, Fps, Overwrite, say_rate
from motes.cli.track_units import UnitOptions, check_size
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.correction.history import History
    from motes.video.sources import Source

app = App(name="draw", help_format="plaintext")


@app.default
def draw(
    source: str,
    rows: Path,
    /,
    *,
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            help="Video with the tracks drawn: .mp4, .mkv, .mov or .m4v.",
        ),
    ] = None,
    figures: Annotated[
        Path | None,
        Parameter(
            group=OUTPUT,
            help="Folder for figures. Of one target: its path, speed and size, .pdf. Of several "
            "objects: a heatmap, their paths, and a slit scan of each line, .png.",
        ),
    ] = None,
    from_: Annotated[
        str | None, Parameter(name="--from", help="Format of the rows. [default: by content]")
    ] = None,
    fps: Fps = None,
    units: UnitOptions = UnitOptions(),
    overwrite: Overwrite = False,
) -> int:
    """Draw rows on their film, and make figures of them.

    The rows may be of any format that motes convert reads. What the file beside rows of motes
    remembers is used: frames, frame rate, scale, lens and ground, lines and zones. Otherwise it may
    be given.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        The rows: of motes track, refine, smooth or watch, or another tool's.
    """
    from motes.cli.draw_rows import draw_objects, draw_target, rows_in
    from motes.correction.history import history_beside
    from motes.rows.writer import check_writable

    if output is None and figures is None:
        raise ConfigError("Nothing is to be made; give -o film.mp4, --figures FOLDER, or both.")
    for name in (source, str(rows)):
        check_not_source(name, output)
    if output is not None:
        check_writable(output, overwrite)
    known = history_beside(rows)
    if fps is not None and known is not None and known.fps not in (None, fps):
        raise ConfigError(f"--fps is {fps:g}, and the rows are of {known.fps:g}; omit it.")
    if figures is not None:
        prepare_folder(figures, [], overwrite)
    with _opened(source, fps, known) as film:
        say_rate(film)
        given = rows_in(rows, from_, film, known)
        plane = units_of(rows, False, units, known)
        check_size(plane, film)
        if given.single:
            return draw_target(film, given, plane, output, figures, overwrite=overwrite)
        return draw_objects(film, given, plane, known, output, figures, overwrite=overwrite)


def _opened(source: str, fps: float | None, known: History | None) -> Source:
    """Return the film of rows, with the frames of their run.

    Raises
    ------
    InputError
        If it is another film.
    """
    from motes.video.sources import is_recorded, open_source

    if not is_recorded(source):
        raise ConfigError(f"{source} is read once, as it comes; give the recording of these rows.")
    if known is None:
        return open_source(source, fps=fps)
    film = open_source(
        source, start=known.start, end=known.end, stride=known.stride, fps=known.fps or fps
    )
    try:
        known.check(film)
    except BaseException:
        film.close()
        raise
    return film
