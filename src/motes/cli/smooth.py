"""`motes smooth`: rows in hindsight."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source, point_out_unfinished
from motes.cli.known_run import units_of
from motes.cli.option_groups import HYPHEN, OUTPUT, FileName, Identity, Overwrite
from motes.cli.streams import log
from motes.core.errors import counted
from motes.core.files import check_writable
from motes.core.track import GROUND
from motes.correction.correct import smooth as smoothed
from motes.correction.history import History, check_beside, hand_on
from motes.correction.rows import KnownRows
from motes.mot.analytics.real_units import motion_in_hindsight
from motes.rows.schema import HINDSIGHT
from motes.rows.writer import TrackWriter

app = App(name="smooth", help_format="plaintext")


@app.default
def smooth(
    rows: Path,
    /,
    *,
    identity: Identity = None,
    output: Annotated[FileName, HYPHEN, Parameter(name=["--output", "-o"], group=OUTPUT)],
    overwrite: Overwrite = False,
) -> int:
    """Smooth the rows of one target, flag outliers and bridge gaps.

    Frames that the tracker has lost, between others that it has tracked, get the status
    interpolated, and standard deviations that grow from both sides. They are no surer than before,
    and have metres only with a confidence of one half or more. A jump away and back is left out,
    and has a 1 in the column outlier.

    Parameters
    ----------
    rows
        A .csv or .jsonl file that a plain motes track has written, without keyframes.
    output
        File of the smoothed rows, .csv or .jsonl, or - for standard output.
    """
    check_not_source(str(rows), Path(output))
    table, whole = KnownRows(rows, identity=identity), History.beside(rows)
    known = whole and whole.of(identity)
    table.check_plain()
    point_out_unfinished(rows, whole)
    table.check_whole()
    plane = units_of(rows, table.metres, known)
    if output != "-":
        check_writable(output, overwrite)  # these are named first, not what is beside them
        check_beside(Path(output), overwrite)
    tracks = smoothed(table.tracks)
    places = motion_in_hindsight(plane, tracks)
    further = HINDSIGHT if plane is None else (*HINDSIGHT, *GROUND)
    with TrackWriter(output, overwrite=overwrite, further=further) as writer:
        for track, place in zip(tracks, places, strict=True):
            writer.add(table.row(track, place))
    if output != "-":
        hand_on(known, Path(output))
    only = f" of object {table.identity} alone" * table.several
    states = Counter(str(track.status) for track in tracks)
    parts = [counted(len(tracks), "frame"), *(f"{s} in {n}" for s, n in states.most_common())]
    parts.append(counted(sum(track.outlier for track in tracks), "outlier"))
    log(", ".join(parts) + (f"; wrote {output}{only}." if output != "-" else "."))
    return DONE
