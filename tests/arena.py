"""Sequences and trackers for tests of evaluations: on disk, tiny, good and bad."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest
from PIL import Image

from commands import read_csv
from motes import synthetic
from motes.synthetic.clips import Clip
from motes_lab.cli import main
from waiting import runs

SIZE = (160, 120)
FRAMES = 20
Go = Callable[[str], tuple[int, str, str]]

TRACKERS = '''
"""Trackers that a test evaluates."""

import os
import time


class Still:
    """Stays where it is put, or `step` pixels further in every frame."""

    step = 0.0

    def init(self, image, box):
        assert image.shape == (120, 160, 3) and image.dtype == "uint8"
        self.box, self.frames = box, 0

    def update(self, image):
        assert image.any()
        image[:] = 0  # as some do; the next pass shall not see it
        self.frames += 1
        x, y, width, height = self.box
        return x + self.frames * self.step, y, width, height


class Seeded(Still):
    def __init__(self, seed):
        self.step = 0.1 * seed


class Raises(Still):
    def update(self, image):
        if self.frames == 6:
            raise ValueError("no more\\nof this")
        return super().update(image)


class Exits(Raises):
    def update(self, image):
        if self.frames == 6:
            raise SystemExit(3)
        return super().update(image)


class Interrupts(Raises):
    def update(self, image):
        if self.frames == 6:
            raise KeyboardInterrupt
        return super().update(image)


class Dies(Still):
    def update(self, image):
        os._exit(7)


class Waits(Still):
    """Says who it is, and waits until there is a file `released`."""

    def init(self, image, box):
        super().init(image, box)
        with open("processes", "a") as file:
            print(os.getpid(), file=file)

    def update(self, image):
        while not os.path.exists("released"):
            time.sleep(0.01)
        return super().update(image)


class Hangs(Waits):
    def update(self, image):
        time.sleep(1000)


nothing = 3
'''


@cache  # its ground is rendered once
def still() -> Clip:
    """Return a clip whose target hardly moves."""
    return synthetic.still(SIZE, target=(30, 40), frames=FRAMES)


def write_sequence(folder: Path, clip: Clip) -> None:
    """Write a clip as OTB has its sequences."""
    (folder / "img").mkdir(parents=True)
    rows = []
    for frame, truths in clip:
        Image.fromarray(frame.pixels).save(folder / "img" / f"{frame.index + 1:04d}.png")
        x, y, width, height = truths[0].ellipse.box
        rows.append(f"{x + 1},{y + 1},{width},{height}\n")
    (folder / "groundtruth_rect.txt").write_text("".join(rows))


@contextlib.contextmanager
def at_home(folder: Path, module: str) -> Iterator[None]:
    """Make a folder the current one, from which a module of trackers is imported anew."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "path", sys.path[:])
        patch.delitem(sys.modules, module, raising=False)
        yield
        sys.modules.pop(module, None)


def evaluating(capfd: pytest.CaptureFixture[str]) -> Go:
    """Return what runs `motes-lab evaluate`: exit code, standard output, standard error."""

    def run(line: str) -> tuple[int, str, str]:
        capfd.readouterr()
        code = main(["evaluate", *line.split()])
        return code, *capfd.readouterr()

    return run


def table(out: str) -> list[dict[str, str]]:
    """Return the rows of an evaluation's results."""
    return read_csv(Path(out, "results.csv"))


def tracks(out: Path) -> dict[str, list[str]]:
    """Return the tracks of an evaluation without their running times."""
    return {
        str(path.relative_to(out)): [
            ",".join(field for i, field in enumerate(line.split(",")) if i != 8)
            for line in path.read_text().splitlines()
        ]
        for path in sorted(out.glob("tracks/*/*/*.csv"))
    }


def all_gone(processes: Path) -> bool:
    """Return whether all processes have ended that told a file their numbers."""
    return not any(runs(int(number)) for number in processes.read_text().split())
