"""A fusion rule and a format of another package."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from motes import Config, Ellipse, Track
from motes.core import Floats
from motes.filtering import Fusion, Weights
from motes.formats import FilmFacts, Format, Recording


class Least(Fusion, Config, frozen=True, tag="least"):
    """A particle is as good as the cue says that likes it least."""

    power: float = 1.0
    """Power of that cue's likelihood. With a larger value, fewer particles share the weight."""

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,)."""
        weights = Weights.from_log(prior + self.power * logs.min(axis=0))
        return weights, self.reliability(names)


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the object in a file of lines: frame left top width height."""
    objects = []
    for line in path.read_text().splitlines():
        frame, *box = map(float, line.split())
        objects.append(Track(int(frame), math.nan, Ellipse.from_box(box)))
    return Recording.of(facts, objects)


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame with the object."""
    for frame, row in recorded.only_object("boxes").items():
        yield " ".join(f"{number:.2f}" for number in (frame, *row.box)).encode() + b"\n"


BOXES = Format(title="boxes", endings=(".boxes",), read=read, write=write, single=True)
