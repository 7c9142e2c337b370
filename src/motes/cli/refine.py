"""`motes refine`: correct rows, and track again only what the corrections change."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source, refuse
from motes.cli.keyframe_options import Absent, At, File, marks
from motes.cli.load_config import tracker_config
from motes.cli.messages import counted, log
from motes.cli.options import CONFIGURATION, OUTPUT, PRESETS, ConfigFile, Overwrite
from motes.cli.settings import TRACKER_HELP, Settings
from motes.cli.track_units import UnitOptions
from motes.core import interrupts
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.correction.history import History
    from motes.correction.rows import Rows
    from motes.mot.analytics.real_units import RealUnits
    from motes.sot.presets import TrackerConfig
    from motes.video.film import Film

app = App(name="refine", help_epilogue=TRACKER_HELP, help_format="plaintext")


@app.default
def refine(
    source: str,
    rows: Path,
    /,
    *,
    at: At = None,
    absent: Absent = None,
    keyframes: File = None,
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            help="File of the corrected rows; by default the rows are changed in place.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    preset: Annotated[str | None, Parameter(group=CONFIGURATION, help=PRESETS)] = None,
    config: ConfigFile = None,
    units: UnitOptions = UnitOptions(),
    seed: Annotated[
        int | None, Parameter(group=CONFIGURATION, help="Seed of the random numbers.")
    ] = None,
    **settings: Settings,
) -> int:
    """Correct rows of one target, and track again only what changes.

    The stretches between the corrected frames and their neighboring keyframes are tracked again, in
    both directions, and smoothed. All other rows stay as they are, to the byte. The history of
    corrections is kept beside the rows, in ROWS.corrections.json; from it the run can be repeated,
    and an interrupted one is finished by the next motes refine.

    Rows of a plain motes track have one keyframe, their first frame. The tracker and the real units
    are given with the first correction.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        A .csv or .jsonl file that motes track, smooth or refine has written.
    """
    from motes.cli.refine_run import refine_rows
    from motes.correction.history import History, history_path
    from motes.correction.rows import Rows
    from motes.output.track_rows import check_writable

    path = history_path(rows)
    history = History.load(path) if path.exists() else None
    table = Rows(rows, growing=history is not None and bool(history.unfinished))
    goal = rows if output is None else output
    check_not_source(source, goal)
    if output is not None:
        if output.suffix.lower() != rows.suffix.lower():
            raise ConfigError(f"{output} has another form than {rows}; give it the same ending.")
        check_writable(output, overwrite)
        check_writable(history_path(output), overwrite)
    new = marks(source, keyframes, at, absent)
    if history is not None:
        own = {"--preset": preset, "--config": config, "--seed": seed, **units.given}
        own |= {f"--{key}": value for key, value in settings.items()}
        refuse(own, f"already in {history_path(rows).name}, beside the rows")
        film = known_film(source, history)
    else:
        tracker = tracker_config(app, preset or "default", config, settings)
        film = film_of(source, table)
        plane = units.units()
        if table.metres and plane is None:
            raise ConfigError(
                f"{rows} has metres; give --scale or --ground, and --lens, as for these rows."
            )
        history = begun(film, table, tracker, seed or 0, plane)
    table.check(film)
    if not new and not history.unfinished:
        raise ConfigError("There is nothing to correct; give --at N=x,y,width,height or --absent.")
    after = history.corrected(new)
    made, interrupted = refine_rows(film, table, history, after, goal)
    log(
        f"{interrupts.word(interrupted)}{counted(len(after.corrections[-1]), 'correction')}, "
        f"{counted(made, 'row')} of {len(table.frames)} made anew; wrote {goal}."
    )
    return interrupts.code(interrupted) if interrupted else DONE


def known_film(source: str, history: History) -> Film:
    """Return the film of rows that have a history, with the frames that are used.

    Raises
    ------
    InputError
        If it is another film.
    """
    from motes.video.film import Film

    film = Film(source)
    history.check(film)
    name = Path(film.name).name
    if name != history.film:
        log(f"{name} has the size and the frames of {history.film}, and is taken for it.")
    return film.part(history.start, history.end)


def film_of(source: str, table: Rows) -> Film:
    """Return the film of rows without a history, with the frames of the rows."""
    from motes.video.film import Film

    film = Film(source)
    table.check(film)
    return film.part(table.frames[0], table.frames[-1] + 1)


def begun(
    film: Film, table: Rows, tracker: TrackerConfig, seed: int, units: RealUnits | None = None
) -> History:
    """Return the history of rows of motes track, whose first target is their keyframe.

    Raises
    ------
    ConfigError
        If there is no tracked row.
    """
    from motes.correction.history import History

    first = table.first_tracked
    mark = first.ellipse if first.ellipse.theta else first.box
    return History.begin(film, tracker, seed, [(first.frame, mark)], units)
