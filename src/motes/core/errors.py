"""The errors that motes raises; every message names the problem and the remedy."""

LONGEST = 1200
"""Largest number of characters of a message."""


def clear(text: str) -> str:
    """Return a message as one printable line, whatever it quotes from a damaged file.

    Unprintable characters are escaped. Long messages are cut in the middle.
    """
    if not text.isprintable():
        text = "".join(map(_shown, text))
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST * 3 // 4]} ... {text[-LONGEST // 4 + 5 :]}"


def _shown(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else character.encode("unicode_escape").decode()


def counted(number: int, noun: str) -> str:
    """Return `1 frame` or `2 frames`."""
    return f"{number} {noun}{'s' * (number != 1)}"


class MotesError(Exception):
    """Base of all errors that motes raises on purpose."""

    def __str__(self) -> str:
        return clear(super().__str__())


class SourceError(MotesError):
    """A video, image or stream cannot be read."""


class AwayError(SourceError):
    """A live source has ended, and has not come back in the time that it may be away."""


class FormatError(MotesError):
    """A file of results has the wrong form, exists already, or cannot be read or written."""


class InputError(FormatError):
    """A file of rows, keyframes or annotations cannot be read, or belongs to another film."""


class ConfigError(MotesError, ValueError):
    """A configuration, an option or a region cannot be used."""


class MissingDependencyError(MotesError):
    """An optional package is not installed."""


class PluginError(MotesError):
    """A package that extends motes cannot be used."""
