"""How many instructions it takes to follow a target, and a guess at speed on small boards.

    python benchmarks/instructions.py [FRAMES]        # needs valgrind; takes some minutes

Instructions are counted by valgrind in code for any x86-64 processor, whose vectors have 128 bits
as those of the boards do; a run over fewer frames is subtracted, and with it all that starting
takes. Frames per second on a board are a guess from these: its clock times the instructions that
it may get done in a cycle, the lower and the higher guess.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from msgspec.structs import replace

from motes import Tracker, kernels
from motes.cli import main as command_line
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import preset
from motes.synthetic.clips import still
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

SIZE, TARGET = (320, 240), (30, 50)
PRESETS = ("nummiaro", "ng_delp", "maggio")
FEW, MORE = 10, 310
"""Frames of the short runs and, by default, of the long ones."""
TRACK = "nummiaro"
"""The preset of `motes track`."""
BOARDS = {
    "Raspberry Pi 4 (Cortex-A72, 1.5 GHz)": (1.5e9, 0.7, 1.4),
    "Raspberry Pi Zero 2 W (Cortex-A53, 1.0 GHz)": (1.0e9, 0.4, 0.8),
}
"""Cycles in a second, and how many instructions are done in one, at least and at most."""
ANY_PROCESSOR = """
import importlib.machinery, importlib.util, runpy, sys
name = "motes.kernels._baseline"
loader = importlib.machinery.ExtensionFileLoader(name, sys.argv[1])
baseline = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
sys.modules["motes.kernels._avx2"] = baseline
sys.argv = sys.argv[2:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
"""Runs a file with the kernels for any processor in the place of all others."""


def update(name: str, frames: int) -> None:
    """Follow a target through so many frames of eight in turn."""
    config = preset(name)
    assert isinstance(config, ParticleFilter)
    tracker = Tracker(replace(config, presence=replace(config.presence, max_positions=1000)))
    clip = still(SIZE, TARGET, 8)
    pixels = [frame.pixels for frame, _ in clip]
    tracker.init(pixels[0], clip[0][1][0].ellipse)
    for i in range(1, frames):
        tracker.update(pixels[i % 8])


def instructions(arguments: list[str]) -> int:
    """Return how many instructions Python executes with some arguments."""
    # Valgrind knows no vectors of 512 bits.
    environment = os.environ | {"PYTHONHASHSEED": "0", "OPENBLAS_CORETYPE": "Haswell"}
    (baseline,) = Path(kernels.__file__).parent.glob("_baseline.*.so")
    command = [sys.executable, "-c", ANY_PROCESSOR, str(baseline), __file__, *arguments]
    counter = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={os.devnull}"]
    done = subprocess.run([*counter, *command], env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(arguments)} failed under valgrind:\n{done.stderr}")
    (found,) = re.findall(r"Collected : (\d+)", done.stderr)
    return int(found)


def main(more: int) -> None:
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is not installed; on Debian: apt install valgrind")
    works = {f"an update of {name}": [name] for name in PRESETS}
    rows: list[Row] = []
    with TemporaryDirectory() as name:
        folder = Path(name)
        film = folder / "film.mp4"
        clip = still(SIZE, TARGET, more)
        with VideoWriter(film, 25) as writer:
            for frame, _ in clip:
                writer.write(frame.pixels)
        box = ",".join(f"{value:.0f}" for value in clip[0][1][0].ellipse.box)
        track = ["track", str(film), "--init", box, "--preset", TRACK]
        track += ["-o", str(folder / "rows.csv"), "--overwrite", "--end"]
        works[f"a frame of motes track with {TRACK}"] = track
        for what, arguments in works.items():
            counts = [instructions([*arguments, str(frames)]) for frames in (FEW, more)]
            each = (counts[1] - counts[0]) / (more - FEW)
            guesses = (
                f"{low * hertz / each:.0f} to {high * hertz / each:.0f}"
                for hertz, low, high in BOARDS.values()
            )
            rows.append((Cell(what), Cell(f"{each / 1e6:.2f}"), *map(Cell, guesses)))
            print(what, counts, file=sys.stderr)
    head = ("what", "million instructions", *(f"{board}, a second" for board in BOARDS))
    print(markdown.table(Table(f"Estimates at {SIZE[0]}x{SIZE[1]}", head, rows)))


if __name__ == "__main__":
    if sys.argv[1:2] == ["track"]:
        sys.exit(command_line(sys.argv[1:]))
    elif len(sys.argv) > 2:
        update(sys.argv[1], int(sys.argv[2]))
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else MORE)
