"""`motes draw`: overlay, figures and masks of any rows, whatever has made or changed them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.annotated_video import AnnotatedVideo, ScenePainter, TargetPainter
from motes.cli.draw_rows import object_moments, rows_in, target_moments
from motes.cli.frame_loop import Sink, Tally, run
from motes.cli.input_checks import (
    check_not_source,
    check_order,
    point_out_leftovers,
    point_out_unfinished,
    prepared_folder,
    refuse,
)
from motes.cli.known_run import beside
from motes.cli.option_groups import OUTPUT, FileName, Fps, OutputFile, Overwrite, options, say_rate
from motes.cli.pictures import Heatmap, Masks, MotionFigures, Paths, Slits
from motes.cli.track_units import UnitOptions, check_size
from motes.core.errors import ConfigError
from motes.correction.history import History
from motes.mot.analytics.real_units import RealUnits
from motes.mot.analytics.regions import Regions
from motes.video.sources import Source, is_recorded, open_source

app = App(name="draw", help_format="plaintext")


@options(OUTPUT)
class DrawOutputs:
    """The pictures that are made."""

    output: OutputFile = None
    """Video with the tracks drawn: .mp4, .mkv, .mov or .m4v."""
    figures: Path | None = None
    """Folder for figures. Of one target: its path, speed and size, .pdf. Of several objects: a
    heatmap, their paths, and a slit scan of each line, .png."""
    masks: Path | None = None
    """Masks of one target: its pixels, where their colors differ from those around it. A folder for
    PNG files, or a .json document of COCO."""
    label: str | None = None
    """Class of the target in a document of masks. [default: object]"""
    overwrite: Overwrite = False

    def of_target(self, film: Source, name: str, *, metres: bool) -> list[Sink]:
        """Return the outputs of rows of one target; `name` begins those of its figures."""
        opened, anew = list[Sink](), self.overwrite
        if self.output is not None:
            painter = TargetPainter(metres=metres)
            opened.append(AnnotatedVideo(self.output, film, painter, 1, overwrite=anew))
        if self.figures is not None:
            unit = "m" if metres else "pixels"
            opened.append(MotionFigures(self.figures / name, unit, overwrite=anew))
        if self.masks is not None:
            opened.append(Masks(self.masks, film, self.label, overwrite=anew))
        return opened

    def of_objects(self, film: Source, name: str, regions: Regions) -> list[Sink]:
        """Return the outputs of rows of several objects."""
        if self.masks is not None:
            raise ConfigError(
                "--masks is for rows of one target; motes convert --identity makes such rows."
            )
        opened, anew = list[Sink](), self.overwrite
        if self.output is not None:
            painter = ScenePainter(regions)
            opened.append(AnnotatedVideo(self.output, film, painter, 1, overwrite=anew))
        if self.figures is not None:
            opened.append(Heatmap(self.figures / f"{name}.heatmap.png", overwrite=anew))
            opened.append(Paths(self.figures / f"{name}.paths.png", overwrite=anew))
            if regions.line:
                opened.append(Slits(self.figures / f"{name}.slit.png", regions, overwrite=anew))
        return opened


@app.default
def draw(
    source: FileName,
    rows: Path,
    /,
    *,
    outputs: DrawOutputs = DrawOutputs(),
    from_: Annotated[str | None, Parameter(name="--from")] = None,
    fps: Fps = None,
    units: UnitOptions = UnitOptions(),
) -> int:
    """Draw rows on their film, and make figures and masks of them.

    The rows may be of any format that motes convert reads. What the file beside rows of motes
    remembers is used: frames, frame rate, scale, lens and ground, lines and zones. Otherwise it may
    be given.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        The rows: of motes track, refine, smooth or watch, or another tool's.
    from_
        Format of the rows. [default: by content]
    """
    output, figures, masks = outputs.output, outputs.figures, outputs.masks
    if output is None and figures is None and masks is None:
        raise ConfigError("Nothing is to be made; give -o film.mp4, --figures or --masks FOLDER.")
    check_order(source, rows)
    for name in (source, str(rows)):
        check_not_source(name, output, figures, masks)
    if outputs.label is not None and (masks is None or masks.suffix.lower() != ".json"):
        raise ConfigError("--label is for masks in a document, as .json; omit it.")
    point_out_leftovers(output, masks)
    known = History.beside(rows)
    point_out_unfinished(rows, known)
    if fps is not None and known is not None and known.fps not in (None, fps):
        raise ConfigError(f"--fps is {fps:g}, and the rows are of {known.fps:g}; omit it.")
    with (
        _opened(source, fps, known) as film,
        prepared_folder(figures, [], outputs.overwrite),
        prepared_folder(masks and masks.parent, [], outputs.overwrite),
    ):
        say_rate(film)
        given = rows_in(rows, from_, film, source, known)
        plane = _units(rows, units, known)
        if given.metres and known is None:
            refuse(units.given, f"for rows without metres, and {rows} has them")
        if output is None and not given.single:
            refuse(units.given, "for rows of one target, and for the speeds in a video, -o")
        check_size(plane, film.name, film.width, film.height)
        if given.single:
            opened = outputs.of_target(film, rows.stem, metres=plane is not None or given.metres)
            return run(film, opened, target_moments(film, given, plane), Tally())
        regions = (known and known.places) or Regions()
        opened = outputs.of_objects(film, rows.stem, regions)
        return run(film, opened, object_moments(film, given, regions, plane), Tally())


def _units(rows: Path, options: UnitOptions, known: History | None) -> RealUnits | None:
    """Return how pixels become metres; None if they do not.

    Raises a ConfigError if another way is given than is remembered.
    """
    plane = options.units()
    if known is None or known.units is None:
        return plane
    if plane not in (None, known.units):
        refuse(options.given, beside(rows))
    return known.units


def _opened(source: str, fps: float | None, known: History | None) -> Source:
    """Return the film of rows, with the frames of their run.

    Raises an InputError if it is another film.
    """
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
