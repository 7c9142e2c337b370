"""Keyframes on the command line, and films that are tracked in any direction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from motes.cli.options import FLAG, HYPHEN, REPEATED
from motes.core.errors import ConfigError, InputError, MotesError

KEYFRAMES = Group("Keyframes", sort_key=1)
Marks = list[tuple[int, Sequence[float] | None]]

At = Annotated[
    list[str] | None,
    REPEATED,
    HYPHEN,
    Parameter(
        group=KEYFRAMES,
        help="Keyframe: N=x,y,width,height or N=x,y,a,b,theta, the target in frame N. Repeat it.",
    ),
]
Absent = Annotated[
    list[str] | None,
    REPEATED,
    HYPHEN,
    Parameter(
        group=KEYFRAMES,
        help="Frames without the target: N or FIRST:LAST, the last one included. Repeat it.",
    ),
]
File = Annotated[
    Path | None,
    Parameter(
        group=KEYFRAMES,
        help="File with a keyframe in each row: frame,x,y,width,height, or frame,x,y,a,b,theta, or "
        "FIRST:LAST,absent. With several films, a row begins with the name of its film.",
    ),
]


@Parameter(name="*", group=KEYFRAMES)
@dataclass(frozen=True, kw_only=True)
class KeyframeOptions:
    """Where a target is known, and in which direction it is tracked."""

    keyframes: File = None
    at: At = None
    absent: Absent = None
    from_: Annotated[
        int | None,
        Parameter(
            name="--from",
            help="Frame of --init or --ellipse; from there the target is tracked in both "
            "directions, or with --backward back to the start.",
        ),
    ] = None
    backward: Annotated[
        bool,
        FLAG,
        Parameter(help="Track backward; --init or --ellipse is the target in the last frame."),
    ] = False

    @property
    def given(self) -> bool:
        """Whether any of these options is used."""
        return self.keyframes is not None or self.in_one_film

    @property
    def in_one_film(self) -> bool:
        """Whether an option names frames without their film."""
        return any((self.at, self.absent, self.from_ is not None, self.backward))

    def marks(self, source: str) -> Marks:
        """Return the keyframes of these options, for a source.

        Raises
        ------
        ConfigError
            If an option has another form.
        FormatError
            If the file cannot be read, or has keyframes of other films only.
        """
        return marks(source, self.keyframes, self.at, self.absent)


def marks(
    source: str, file: Path | None, at: Sequence[str] | None, absent: Sequence[str] | None
) -> Marks:
    """Return the keyframes of --keyframes, --at and --absent."""
    from motes.correction.keyframes import ABSENT, keyframes_of, marks_of

    found: Marks = []
    if file is not None:
        with other_format_named(file):
            found += keyframes_of(file, source).items()
    for text in at or []:
        frame, equals, region = text.partition("=")
        if not equals:
            raise ConfigError(f"--at takes N=x,y,width,height; got {text!r}.")
        found += marks_of(frame, region)
    for text in absent or []:
        found += marks_of(text, ABSENT)
    return found


@contextmanager
def other_format_named(file: Path) -> Iterator[None]:
    """Turn the error of a file that holds no keyframes into advice, if it has a known format."""
    from motes.formats.registry import recognized

    try:
        yield
    except InputError:
        try:
            form = recognized(file)
        except MotesError:
            form = "keyframes"
        if form != "keyframes":
            raise InputError(
                f"{file} holds no keyframes, but has the format {form}; make them with motes "
                f"convert {file} {file.stem}.keyframes.csv."
            ) from None
        raise
