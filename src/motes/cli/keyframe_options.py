"""Keyframes on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.options import HYPHEN, KEYFRAMES, REPEATED, TARGET
from motes.core.errors import ConfigError, InputError, MotesError

Marks = list[tuple[int, Sequence[float] | None]]

At = Annotated[
    list[str] | None,
    REPEATED,
    HYPHEN,
    Parameter(
        group=TARGET,
        help="The target in any frame: FRAME=x,y,width,height or FRAME=x,y,a,b,theta. It is "
        "tracked both ways from there, and between two such frames. Repeat it.",
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
        "FIRST:LAST,absent. A row may begin with the name of its film: others are left out.",
    ),
]


@Parameter(name="*", group=KEYFRAMES)
@dataclass(frozen=True, kw_only=True)
class KeyframeOptions:
    """Where a target is known."""

    keyframes: File = None
    at: At = None
    absent: Absent = None

    @property
    def given(self) -> bool:
        """Whether any of these options is used."""
        return self.keyframes is not None or bool(self.at or self.absent)

    def checked_marks(self, source: str, region: Sequence[float] | None) -> Marks:
        """Return the keyframes of these options for a source, which go with the region of --init.

        Raises
        ------
        ConfigError
            If an option has another form, or nothing marks the target.
        FormatError
            If the file cannot be read, or has keyframes of other films only.
        """
        found = marks(source, self.keyframes, self.at, self.absent)
        if region is None and not any(mark for _, mark in found):
            raise ConfigError(
                "The target is missing. Give --at FRAME=x,y,width,height, or --init x,y,width,"
                "height."
            )
        return found


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
            raise ConfigError(f"--at takes FRAME=x,y,width,height; got {text!r}.")
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
