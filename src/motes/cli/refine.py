"""`motes refine`: correct rows, and track again only what the corrections change."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App
from msgspec.structs import replace

from motes.cli.correct_run import refine_rows
from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source, point_out_meant
from motes.cli.known_run import TrackerOptions, corrected_run
from motes.cli.load_config import TRACKER_HELP
from motes.cli.option_groups import FileName, Identity, OutputFile, Overwrite
from motes.cli.streams import log
from motes.cli.track_options import KeyframeOptions
from motes.core import interrupts
from motes.core.errors import ConfigError, counted
from motes.core.files import check_writable
from motes.correction.history import History
from motes.correction.keyframes import number_of

app = App(name="refine", help_epilogue=TRACKER_HELP, help_format="plaintext")


@app.default
def refine(
    source: FileName,
    rows: Path,
    /,
    *,
    identity: Identity = None,
    keys: KeyframeOptions = KeyframeOptions(),
    output: OutputFile = None,
    overwrite: Overwrite = False,
    tracker: TrackerOptions = TrackerOptions(),
) -> int:
    """Correct rows of one target, and track again only what changes.

    The stretches between the corrected frames and their neighboring keyframes are tracked again, in
    both directions, and smoothed. All other rows stay as they are, to the byte. Rows of a
    plain motes track have one keyframe, their first frame. The tracker is given with the first
    correction.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        A .csv or .jsonl file that motes track, smooth or refine has written.
    output
        File of the corrected rows; by default the rows are changed in place.
    """
    goal = rows if output is None else output
    check_not_source(source, goal)
    if output is not None:
        if output.suffix.lower() != rows.suffix.lower():
            raise ConfigError(f"{output} has another form than {rows}; give it the same ending.")
        check_writable(output, overwrite)
        check_writable(History.path(output), overwrite)
    new, known = keys.marks(source), History.beside(rows)
    if identity is None and not new and known is not None:  # what is left says whose it is
        identity = next((one for one, each in known.objects.items() if each.unfinished), None)
    table, film, history = corrected_run(source, rows, tracker, identity, new)
    if not new and not history.unfinished:
        raise ConfigError(
            "There is nothing to correct; give --at FRAME=x,y,width,height or --absent."
        )
    marks_known = known is not None and bool(known.of(identity).corrections)
    if table.tracks[1:] and not (table.tracked or marks_known):
        said = (
            f"{rows} is not of a tracker of motes, and only its first box is kept. To keep more, "
            f"make keyframes of it with motes convert, and give them to motes track --keyframes"
        )
        if output is None:
            raise ConfigError(f"{said}; else give -o, as nobody could make these boxes anew.")
        log(f"{said}.")
    if not history.unfinished:  # else those that are not there yet are made now
        table.check_whole()
    after = history.corrected(new)
    marked = after.keys  # which takes time to make, with long absences
    for frame in dict(new):
        point_out_meant(marked.get(frame), film.width, film.height)
    whole = None
    if table.several:  # others may be in frames in which this one is not
        whole = known or replace(history, start=0, end=history.frames, corrections=[])
    made, interrupted = refine_rows(film, table, history, after, goal, whole)
    log(
        f"{interrupts.word(interrupted)}{counted(number_of(dict(new)), 'correction')}, "
        f"{counted(made, 'row')} of {len(table.frames)} made anew; wrote {goal}."
    )
    return interrupts.code(interrupted) if interrupted else DONE
