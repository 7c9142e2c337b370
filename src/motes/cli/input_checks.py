"""Checks of options and files, before anything is computed."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from motes.cli.streams import log
from motes.core import labels
from motes.core.addresses import parts_of
from motes.core.errors import ConfigError, FormatError
from motes.core.files import check_writable, leftovers, same_file
from motes.rows.schema import FORMS, journal_of

if TYPE_CHECKING:
    from motes.cli.option_groups import OutputOptions
    from motes.correction.history import History

STREAMED = ("csv", "jsonl", "mot")
"""Formats that grow row by row; all others are made at the end."""
MOST = 1_000_000
"""Largest number of seeds, rendered frames or rounds; more would take days."""
REGION = "x,y,width,height", "x,y,a,b,theta"
"""The two forms of a region: a box and an ellipse."""


def numbers_of(flag: str, text: str, *forms: str) -> list[float]:
    """Return the numbers of an option in one of some forms, such as x,y,width,height.

    Raises a ConfigError if the text has none of them.
    """
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in [len(form.split(",")) for form in forms]:
        raise ConfigError(f"{flag} takes {' or '.join(forms)}, numbers with commas; got {text!r}.")
    return numbers


def check_counts(**counts: int) -> None:
    """Raise a ConfigError unless each number is from 1 to `MOST`."""
    for name, count in counts.items():
        if count < 1:
            raise ConfigError(f"--{name} is {count}; give 1 or more.")
        if count > MOST:
            raise ConfigError(f"--{name} is {count}; give {MOST} or fewer.")


def point_out_meant(region: Sequence[float] | None, width: int, height: int) -> None:
    """Say if the numbers of a region may be corners of a box, or a box and its score."""
    from motes.core.geometry import perhaps_meant  # brings NumPy, which the help does without

    if region is not None and (meant := perhaps_meant(region, width, height)):
        log(f"The region leaves the picture of {width}x{height}; give {meant}.")


def refuse(options: Mapping[str, object], why: str) -> None:
    """Raise a ConfigError that names the options that are given, if any is.

    One that is not given is None, False or empty; `why` is what they are, as in `not for
    keyframes`.
    """
    given = [name for name, value in options.items() if value is not None and value is not False]
    given = [name for name in given if options[name] not in ("", [], ())]
    if given:
        names = " and ".join([", ".join(given[:-1]), given[-1]] if given[1:] else given)
        plural = len(given) > 1
        raise ConfigError(
            f"{names} {'are' if plural else 'is'} {why}; omit {'them' if plural else 'it'}."
        )


@contextlib.contextmanager
def error_context(where: Path | str) -> Iterator[None]:
    """Add the file or option to the message of a configuration's error."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None


class RowsGoal(NamedTuple):
    """Where the rows of a run go."""

    name: str
    """A file, or - for standard output."""
    form: str
    """The name of its format."""


def checked_output(
    source: str, outputs: OutputOptions, others: Sequence[str | Path]
) -> RowsGoal | None:
    """Return where the rows go, or None without rows, after a check of all outputs.

    Rows without -o have a name of their own if nothing else is made. Raises a ConfigError if an
    output is the source or another output, or options contradict each other.
    """
    name = outputs.output
    if name is None and not (outputs.overlay or others):
        name = default_output(source)
    goal = None if name is None else RowsGoal(name, format_of(name, outputs.format))
    form = goal and goal.form
    check_label(outputs.label, form)
    check_keyframe_error(outputs.keyframe_error, form)
    check_guesses(form, wanted=outputs.with_guesses)
    names = (name, outputs.overlay, *others)
    files = [Path(each) for each in names if each is not None and each != "-"]
    files += [journal_of(goal.name)] if goal is not None and goal.form not in STREAMED else []
    check_not_source(source, *files)
    point_out_leftovers(*files)
    return goal


def format_of(name: str, form: str | None) -> str:
    """Return the name of an output's format: `form` if given, else that of the name's ending.

    Raises a ConfigError if the ending or the format is unknown, or the format cannot be written.
    """
    from motes.formats.registry import FORMATS, format_for

    if form is None:
        return "csv" if name == "-" else format_for(name)
    if FORMATS.resolve(form).write is None:
        raise ConfigError(f"Files of the format {form} cannot be written; give another one.")
    if name.lower().endswith((".zip", ".gz")):
        raise ConfigError(f"{name}: no archives are made; give another name, and pack it later.")
    if name == "-" and form not in STREAMED:
        raise ConfigError(f"{form} is made at the end of a run; give it a file, not -.")
    return form


def usual_format(name: str) -> str | None:
    """Return the format that a name's ending chooses; None if there is no such one."""
    from motes.formats.registry import format_for

    try:
        return format_for(name)
    except ConfigError:
        return None


def check_several(form: str) -> None:
    """Raise a ConfigError if a format holds one object, but there may be several."""
    from motes.formats.registry import FORMATS

    if FORMATS.resolve(form).single:
        raise ConfigError(f"{form} holds one object, and there may be several; choose another.")


def check_place(name: str, form: str, overwrite: bool) -> None:
    """Check that a file, or a folder, of a format can be made.

    Raises a FormatError if it exists and must not be overwritten, or the folder above is missing or
    protected.
    """
    from motes.formats.registry import FORMATS, check_folder

    known = FORMATS.resolve(form)
    if not known.folder:
        check_writable(name, overwrite)
    elif os.path.isdir(name) and os.listdir(name) and not overwrite:
        raise FormatError(f"{name} has files; choose another name, or overwrite it (--overwrite).")
    elif not os.path.isdir(name):
        check_writable(name)
    else:
        check_folder(Path(name), known)


def default_output(source: str) -> str:
    """Return the output of rows without -o: standard output, or a file if it is a terminal."""
    if not sys.stdout.isatty():
        return "-"
    path = parts_of(source).path if "://" in source else os.path.abspath(source)
    stem = re.sub(r"[^\w .+-]+", "-", Path(path).stem).strip("-") or "tracks"
    log(f"Writing {stem}.csv; choose another name with -o.")
    return f"{stem}.csv"


def check_not_source(source: str, *outputs: Path | None) -> None:
    """Check that source and outputs are different files, also through links.

    Raises a ConfigError if an output is the source, or another output.
    """
    paths = [path for path in outputs if path is not None]
    if any(same_file(source, path) for path in paths):
        raise ConfigError(f"{source} is the source and cannot be an output; choose another name.")
    if any(same_file(*pair) for pair in itertools.combinations(paths, 2)):
        raise ConfigError("Two outputs are the same file; give each its own.")


def check_order(source: str, rows: Path) -> None:
    """Raise a ConfigError if rows are given where the film belongs."""
    if Path(source).suffix.lower() in FORMS:
        raise ConfigError(
            f"The film comes first, then its rows; {source} and {rows} seem to be exchanged."
        )


def point_out_leftovers(*outputs: Path | None) -> None:
    """Print the names of partial files that other runs with the same outputs have left."""
    for path in outputs:
        for left in leftovers(path) if path is not None else []:
            log(f"{left} is an unfinished {path}, of a run that was killed or still goes on.")


def point_out_unfinished(rows: Path, known: History | None) -> None:
    """Say if the run that made rows was not finished, by what is remembered of it."""
    if known is None:
        return
    objects = [(f" --identity {number}", each) for number, each in known.objects.items()]
    left = [(name, each.unfinished) for name, each in [("", known), *objects] if each.unfinished]
    for name, parts in left:
        first, last = parts[0][0], parts[-1][1]
        log(
            f"the run of {rows} was not finished between frames {first} and {last}; finish it "
            f"with: motes refine {known.film} {rows}{name}"
        )
    if not left and known.lines is None and not known.corrections:  # the studio counts no lines
        log(f"the run of {rows} was killed, or still goes on: what comes after them is missing.")


def check_label(label: str | None, form: str | None) -> None:
    """Check the class of the objects in an output of a format; None without an output.

    Raises a ConfigError if the name is empty or unprintable, or the format has no such class.
    """
    from motes.formats import mot
    from motes.formats.registry import FORMATS
    from motes.formats.visibility import CLASSES

    if label is None:
        return
    try:
        labels.check_label(label)
    except ConfigError as error:
        raise ConfigError(f"--label: {error}.") from None
    if form is not None and CLASSES not in FORMATS.resolve(form).holds:
        raise ConfigError(f"--label: {form} holds no classes; omit it.")
    if form in ("mot", "mot-truth") and label.lower() not in (*mot.CLASSES, *mot.SYNONYMS):
        raise ConfigError(f"--label: {form} has no class {label}; it has {', '.join(mot.CLASSES)}.")


def check_keyframe_error(error: float | None, form: str | None) -> None:
    """Raise a ConfigError unless --keyframe-error is pixels, for a format with keyframes."""
    from motes.formats.registry import FORMATS

    if error is None:
        return
    if not 0 <= error < math.inf:
        raise ConfigError(f"--keyframe-error is {error:g}; give a number of pixels, 0 or more.")
    if form is None or not FORMATS.resolve(form).thinned:
        raise ConfigError(
            "--keyframe-error is for CVAT, Label Studio and keyframes; others have none: omit it."
        )


def check_guesses(form: str | None, *, wanted: bool) -> None:
    """Raise a ConfigError if --with-guesses is given for a format that holds guesses anyway."""
    from motes.formats.registry import FORMATS

    if wanted and (form is None or FORMATS.resolve(form).guess is None):
        raise ConfigError(
            "--with-guesses is for documents that would mark or leave out guesses, as COCO, CVAT "
            "and YOLO; others have them anyway: omit it."
        )


@contextlib.contextmanager
def prepared_folder(out: Path | None, files: Iterable[str], overwrite: bool) -> Iterator[None]:
    """Make a folder, if one is asked for, and check that these files can be written there.

    At the end it is removed again if it was made here and nothing is in it. Raises a FormatError if
    the folder or a file cannot be written.
    """
    if out is None:
        yield
        return
    made = [path for path in (out, *out.parents) if not path.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(
            f"The folder {out} cannot be made: {error.strerror}; choose another name."
        ) from None
    try:
        for name in files:
            check_writable(out / name, overwrite)
            point_out_leftovers(out / name)
        yield
    finally:
        with contextlib.suppress(OSError):  # what is not empty stays
            for path in made:
                path.rmdir()
