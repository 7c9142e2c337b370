"""`motes-lab faces train`: train a detector of faces on pictures of one's own."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source
from motes.cli.messages import log
from motes.cli.options import OUTPUT, Overwrite

app = App(name="faces", help_format="plaintext")


@app.command
def train(
    faces: Path,
    /,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group=OUTPUT, help="File of the detector.")
    ],
    overwrite: Overwrite = False,
) -> int:
    """Train a detector of faces, for --face-model of motes track and --detector.model of watch.

    Parameters
    ----------
    faces
        CSV file with a line picture,x,y,width,height for each face in each picture, or the
        picture's name alone if it shows none. Names are relative to the file.
    """
    from motes.rows.writer import check_writable
    from motes_lab.face_training import read_examples, save_detector, train_faces

    check_not_source(str(faces), output)
    check_writable(output, overwrite)
    examples = read_examples(faces)
    with tempfile.TemporaryDirectory() as folder:
        trained = train_faces(examples, Path(folder))
    save_detector(trained, output)
    count = sum(len(example.faces) for example in examples)
    log(
        f"wrote {output}, from {count} faces in {len(examples)} pictures; of these it finds "
        f"{trained.recall:.0%}, and {trained.precision:.0%} of what it finds is a face."
    )
    return DONE
