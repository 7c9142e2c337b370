"""Keyframes on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.options import HYPHEN, KEYFRAMES, REPEATED, TARGET, options
from motes.core.errors import ConfigError, InputError, MotesError

Marks = list[tuple[int, Sequence[float] | None]]


@options(KEYFRAMES)
class KeyframeOptions:
    """Where a target is known."""

    keyframes: Path | None = None
    """File with a keyframe in each row: frame,x,y,width,height, or frame,x,y,a,b,theta, or
    FIRST:LAST,absent. A row may begin with the name of its film: others are left out."""
    at: Annotated[list[str] | None, REPEATED, HYPHEN, Parameter(group=TARGET)] = None
    """The target in any frame: FRAME=x,y,width,height or FRAME=x,y,a,b,theta. It is tracked both
    ways from there, and between two such frames. Repeat it."""
    absent: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """Frames without the target: N or FIRST:LAST, the last one included. Repeat it."""

    @property
    def given(self) -> bool:
        """Whether any of these options is used."""
        return self.keyframes is not None or bool(self.at or self.absent)

    def marks(self, source: str) -> Marks:
        """Return the keyframes of these options for a source.

        Raises
        ------
        ConfigError
            If an option has another form.
        FormatError
            If the file cannot be read, or has keyframes of other films only.
        """
        from motes.correction.keyframes import ABSENT, keyframes_of, marks_of

        found: Marks = []
        if self.keyframes is not None:
            with other_format_named(self.keyframes):
                found += keyframes_of(self.keyframes, source).items()
        for text in self.at or []:
            frame, equals, region = text.partition("=")
            if not equals:
                raise ConfigError(f"--at takes FRAME=x,y,width,height; got {text!r}.")
            found += marks_of(frame, region)
        for text in self.absent or []:
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
