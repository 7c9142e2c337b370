"""Trackers in other programs, with the TraX protocol on their standard input and output.

Čehovin, TraX: The visual Tracking eXchange protocol and library, Neurocomputing 2017. This module
supports one object, color images as files, and rectangles, in versions 1 to 4. A message is a line
such as

    @@TRAX:initialize "file:///folder/000001.png" "120,80,60,40"

with arguments in quotes and properties "key=value"; all other lines are ordinary output of the
program.
"""

from __future__ import annotations

import contextlib
import math
import re
import subprocess
import tempfile
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from motes.core.errors import ConfigError, SourceError
from motes.core.geometry import Box

PREFIX = "@@TRAX:"
OUTPUT_LINES = 3
"""Number of lines of a program's output that are quoted in an error."""
QUIT_TIMEOUT = 2.0
"""Seconds within which a program must end after it is asked to quit."""
VERSION = 4
"""The newest supported version of the protocol."""

_TOKEN = re.compile(r'(?:[^\s"\\]|\\.|"(?:[^"\\]|\\.)*")+')
_PROPERTY = re.compile(r"([\w.]{1,64})=(.*)", re.ASCII | re.DOTALL)


class Message(NamedTuple):
    """A line of the protocol: its name in lower case, arguments and properties."""

    name: str
    arguments: list[str]
    properties: dict[str, str]


def parse(line: str) -> Message | None:
    """Return the message in a line; None if the line has none."""
    if not line.startswith(PREFIX):
        return None
    name, _, rest = line[len(PREFIX) :].strip().partition(" ")
    arguments: list[str] = []
    properties: dict[str, str] = {}
    for token in _TOKEN.findall(rest):
        text = re.sub(r'\\(.)|"', _unescape, token)
        if match := _PROPERTY.fullmatch(text):
            properties[match[1]] = match[2]
        else:
            arguments.append(text)
    return Message(name.lower(), arguments, properties)


def _unescape(match: re.Match[str]) -> str:
    return "\n" if match[1] == "n" else match[1] or ""


def write(name: str, *arguments: str) -> str:
    """Return the line of a message."""
    escaped = (
        text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") for text in arguments
    )
    return " ".join([PREFIX + name, *(f'"{text}"' for text in escaped)]) + "\n"


class Program:
    """A running tracker program; starting it waits for its hello message.

    It belongs to the process group of the caller, and ends with it at the latest.

    Raises
    ------
    SourceError
        From all methods, if the program ends or sends a wrong message.
    ConfigError
        If it cannot be started, or needs input that is not supported.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._name = command[0]
        self._talk: deque[str] = deque(maxlen=OUTPUT_LINES)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                encoding="utf-8",
                errors="replace",
            )
        except OSError as error:
            self._errors.close()
            raise ConfigError(f"{self._name} cannot be started: {error.strerror}.") from None
        try:
            self._version = self._hello()
        except BaseException:
            self.close()
            raise

    def initialize(self, image: Path, box: Box) -> Box | None:
        """Start on the object in a box of an image file; return the box in the program's answer."""
        where = ",".join(f"{value:.10g}" for value in box)
        if self._version < 4:
            self._send(write("initialize", f"file://{image}", where))
        else:
            self._send(write("initialize", where) + write("frame", f"file://{image}"))
        return self._state()

    def frame(self, image: Path) -> Box | None:
        """Return the box of the object in the next image; None if the program gives none."""
        self._send(write("frame", f"file://{image}"))
        return self._state()

    def close(self) -> None:
        """Ask the program to quit, and kill it if it does not."""
        with contextlib.suppress(OSError):
            self._send(write("quit"))
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(QUIT_TIMEOUT)
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            assert stream is not None
            with contextlib.suppress(OSError):  # closing sends what could not be sent before
                stream.close()

    def _hello(self) -> int:
        hello = self._receive("hello")
        for key, ours in (("region", "rectangle"), ("image", "path"), ("channels", "color")):
            theirs = hello.properties.get(f"trax.{key}", ours)
            if ours not in re.split(r"[\s;,]+", theirs):
                raise ConfigError(f"{self._name} needs {key} {theirs}; only {ours} is supported.")
        version = hello.properties.get("trax.version", "1")
        if not version.isdecimal() or not 1 <= int(version) <= VERSION:
            raise ConfigError(f"{self._name} has TraX {version}; 1 to {VERSION} are supported.")
        return int(version)

    def _state(self) -> Box | None:
        state = self._receive("state")
        try:
            numbers = [float(number) for number in ",".join(state.arguments).split(",")]
        except ValueError:
            numbers = []
        if len(numbers) == 1:  # a code that means no region
            return None
        if len(numbers) != 4:
            raise self._error(f"gave {state.arguments} for a rectangle")
        box = Box(*numbers)
        return box if all(map(math.isfinite, box)) and min(box.width, box.height) > 0 else None

    def _send(self, text: str) -> None:
        assert self._process.stdin is not None
        # If the program has ended, the missing answer is reported.
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(text)
            self._process.stdin.flush()

    def _receive(self, expected: str) -> Message:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            message = parse(line)
            if message is None:
                self._talk.append(line)
                continue
            if message.name == "status":  # its name in older versions
                message = message._replace(name="state")
            if message.name == "quit":
                reason = message.properties.get("trax.reason", "")
                raise self._error(f"quit: {reason}" if reason else "quit")
            if message.name != expected:
                raise self._error(f"sent {message.name} instead of {expected}")
            return message
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(QUIT_TIMEOUT)
        code = self._process.poll()
        raise self._error("closed its output" if code is None else f"ended with code {code}")

    def _error(self, what: str) -> SourceError:
        """Return an error with the last lines of the program's output."""
        self._errors.seek(0)
        talk = [
            *self._talk,
            *self._errors.read().decode(errors="replace").splitlines()[-OUTPUT_LINES:],
        ]
        output = " / ".join(line.strip() for line in talk if line.strip())
        return SourceError(f"{self._name} {what}" + (f"; its output: {output}" if output else "."))
