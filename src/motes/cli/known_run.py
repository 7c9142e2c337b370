"""What is remembered beside rows, for the commands that take rows.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_order, error_context, refuse
from motes.cli.load_config import tracker_config
from motes.cli.option_groups import (
    CONFIGURATION,
    PRESETS,
    Changes,
    ConfigFile,
    Fps,
    PresetName,
    Whole,
    options,
    say_rate,
)
from motes.cli.streams import log
from motes.core.errors import ConfigError
from motes.correction.history import History
from motes.correction.keyframes import Mark
from motes.correction.rows import KnownRows
from motes.mot.analytics.real_units import RealUnits
from motes.rows.schema import text_name
from motes.sot import presets
from motes.video.film import Film

UPRIGHT = (
    "These rows have angles, and a box tells none: what is made anew are upright boxes. To keep "
    "angles, mark ellipses instead: --at FRAME=x,y,a,b,theta."
)


@options(CONFIGURATION)
class TrackerOptions:
    """The tracker of rows that do not have one beside them."""

    preset: Annotated[
        PresetName | None, Parameter(help=f"{PRESETS} The default is that of the rows, or default.")
    ] = None
    config: ConfigFile = None
    changes: Changes = None
    seed: Whole | None = None
    """Seed of the random numbers."""
    fps: Fps = None

    @property
    def given(self) -> dict[str, object]:
        """The values of the tracker's options by their names; None if one is not given."""
        return {
            "--preset": self.preset, "--config": self.config, "--set": self.changes or None,
            "--seed": self.seed,
        }  # fmt: skip


def units_of(rows: Path, metres: bool, known: History | None) -> RealUnits | None:
    """Return how the pixels of rows become metres, as it is remembered; None if they do not.

    Raises a ConfigError if the rows have metres, and nothing is remembered.
    """
    if known is not None and known.units is not None:
        return known.units
    if metres:
        raise ConfigError(
            f"{rows} has metres, but nothing beside it tells their scale; put the "
            f"{History.path(rows).name} of its run there, or make the rows anew."
        )
    return None


def film_of_rows(
    source: str, rows: Path, table: KnownRows, fps: float | None, known: History | None
) -> Film:
    """Return the film of rows in a table, up to the end and at the frame rate that are remembered.

    Raises a ConfigError if another rate is given than is remembered, and an InputError if it is
    another film.
    """
    if known is None:
        film = Film(source, fps=fps)
        say_rate(film)
        table.check(film)
        return film
    if fps != known.fps:
        refuse({"--fps": fps}, beside(rows))
    film = Film(source, end=known.frames or known.end, fps=known.fps)
    known.check(film)
    table.check(film)
    name = text_name(Path(film.name).name)
    runs_on = known.frames is None and known.end is None  # to the end of its film
    end = len(film.times)
    if runs_on and known.last is not None and known.last + known.stride < end:
        log(
            f"{rows} ends at frame {known.last}, and {name} at frame {end - 1}; unless the run was "
            f"stopped there, give the film of these rows, {known.film}."
        )
    elif name != known.film:
        log(
            f"{rows} is of {known.film}, and {name} is taken for it, by its size and its times; "
            f"give {known.film} if that is another film."
        )
    return film


def corrected_run(
    source: str,
    rows: Path,
    options: TrackerOptions,
    identity: int | None,
    new: Sequence[Mark] = (),
) -> tuple[KnownRows, Film, History]:
    """Return the rows of one target, their film, and their history with its keyframes.

    Of several targets, that with the identity is taken. Rows of a plain `motes track` get the first
    place of the target as their keyframe, a box if `new` marks are or no row has an angle, and may
    get another tracker. Raises a ConfigError for an unknown option, one that is remembered
    already, or rows without a target; and an InputError if the rows lack this target, or have
    several and none is chosen, or it is another film.
    """
    check_order(source, rows)
    whole = History.beside(rows)
    known = whole and whole.of(identity)
    run = known if known is not None and known.places is None else None  # not that of a scene
    own = options.given
    same = None if any(each is not None for each in own.values()) else run
    if same is not None:
        same.check_tracker(History.path(rows))
    table = KnownRows(rows, growing=bool(known and known.unfinished), identity=identity)
    if known is not None and known.corrections:
        refuse(own, beside(rows))
    plane = units_of(rows, table.metres, known)
    film = film_of_rows(source, rows, table, options.fps, known)
    turned = any(each.placed and each.ellipse.theta for each in table.tracks)
    forms = {len(region) for _, region in new if region is not None}
    if known is not None and known.corrections:
        begun = known.boxed() if 4 in forms else known
        if begun is not known and turned:
            log(UPRIGHT)
        return table, film.part(known.start, known.end or len(film.times)), begun
    preset = options.preset or (run and run.preset) or "default"
    if same is not None:
        tracker, seed = same.tracker, same.seed
    else:
        if options.preset is None:
            with error_context(History.path(rows)):  # which may name a preset that is gone
                presets.preset(preset)
        tracker = tracker_config(preset, options.config, options.changes or ())
        seed = options.seed or 0
    part = film.part(table.frames[0], table.frames[-1] + 1)
    first = table.first_tracked
    boxes = not first.ellipse.theta and (4 in forms or not (turned or forms))
    mark = first.box if boxes else first.ellipse
    if boxes and turned:
        log(UPRIGHT)
    return table, part, History.begin(part, tracker, seed, [(first.frame, mark)], plane, preset)


def beside(rows: Path) -> str:
    """Return why an option is not asked for: it is remembered beside the rows."""
    return f"already in {History.path(rows).name}, beside the rows"
