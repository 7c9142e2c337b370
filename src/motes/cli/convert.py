"""`motes convert`: make a document of the rows that a killed run has left."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source
from motes.cli.messages import log
from motes.cli.options import OUTPUT, Overwrite
from motes.core.errors import FormatError

app = App(name="convert", help_format="plaintext")


@app.default
def convert(
    rows: Path,
    /,
    *,
    output: Annotated[
        Path,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            help="File to make: a document, .json (COCO) or .xml (CVAT), or rows, .csv, .jsonl "
            "or .txt (MOTChallenge).",
        ),
    ],
    overwrite: Overwrite = False,
) -> int:
    """Make a document, or another file, of the rows of a run that could not finish it.

    motes track and motes watch with -o NAME.json or NAME.xml write the objects of each frame into
    NAME.json.rows.jsonl or NAME.xml.rows.jsonl first. This file stays if the run is killed or the
    disk is full. This command makes the document of it. It does not change the file.

    Parameters
    ----------
    rows
        A file whose name ends in .rows.jsonl.
    """
    from motes.cli.watch_outputs import Rows, form_of
    from motes.output.documents import is_document, write_document
    from motes.output.journal import Journal
    from motes.output.track_rows import check_writable

    check_not_source(str(rows), output)
    journal = Journal(rows)
    if is_document(output.name):
        check_writable(output, overwrite)
        try:
            write_document(output, journal)
        except OSError as error:
            raise FormatError(
                f"{output} cannot be written: {error.strerror}; make room, or choose another place."
            ) from error
    else:
        with Rows(str(output), form_of(str(output)), overwrite) as lines:
            for picture in journal:
                lines.add(picture)
    log(f"wrote {output} with the {sum(1 for _ in journal)} frames in {rows}.")
    return DONE
