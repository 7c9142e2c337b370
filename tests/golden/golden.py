"""Outputs of whole commands, kept to the byte: whoever moves code compares them before and after.

    python tests/golden/golden.py            compare with tests/golden/kept
    python tests/golden/golden.py --keep     make them anew

The films are rendered, small and short. What is kept are the rows, events and documents that each
command writes, and digests of the pictures of overlays.
"""

import contextlib
import hashlib
import io
import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from PIL import Image

from motes import open_source, synthetic
from motes.cli import main

KEPT = Path(__file__).parent / "kept"
SIZE, FRAMES = (160, 120), 14
FILMS = ("demo", "jumping", "turning", "growing", "occluded", "crossing")
PRESETS = (
    "default", "nummiaro", "nummiaro:adaptive", "nummiaro:printed", "mean_shift", "maggio",
    "maggio:printed", "ng_delp", "ng_delp:printed", "zhao_pei", "zhao_pei:printed",
)  # fmt: skip
FORMATS = (
    "rows.jsonl", "rows.txt", "truth.otb.txt", "truth.vot.txt", "rows.json", "rows.xml",
    "rows.ls.json", "rows.dlc.csv", "rows.keyframes.csv", "rows.yolo", "rows.det.txt",
)  # fmt: skip
RIG = """
[[camera]]
name = "left"
source = "street/*.png"
fps = 25
[[camera.place]]
name = "edge"
box = [140, 0, 20, 120]
[[camera]]
name = "right"
source = "crossing/*.png"
fps = 25
[[camera.place]]
name = "edge"
box = [0, 0, 20, 120]
[[passage]]
between = ["left/edge", "right/edge"]
"""


def render() -> dict[str, str]:
    """Render the films into the current folder, as images; return the first box of each."""
    boxes = {}
    for name in FILMS:
        os.mkdir(name)
        for frame, truth in islice(getattr(synthetic, name)(SIZE), FRAMES):
            Image.fromarray(np.asarray(frame.pixels)).save(f"{name}/{frame.index:03d}.png")
            if frame.index == 0:
                boxes[name] = ",".join(f"{number:.1f}" for number in truth[0].ellipse.box)
    os.mkdir("street")
    texture = np.random.default_rng(0).integers(60, 120, (120, 160, 3), np.uint8)
    for index in range(60):
        picture = texture.copy()
        x = 3 * index
        for left, y, color in ((x - 40, 30, (220, 40, 30)), (150 - x, 80, (30, 60, 230))):
            picture[y : y + 24, max(left, 0) : max(left + 30, 0)] = color
        Image.fromarray(picture).save(f"street/{index:03d}.png")
    Path("rig.toml").write_text(RIG, encoding="utf-8")
    return boxes


def commands(boxes: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Yield each command with the file or folder that it makes."""
    for film in FILMS:
        for preset in PRESETS if film == "crossing" else PRESETS[:2]:
            out = f"track_{film}_{preset.replace(':', '_')}.csv"
            yield f"track {film} --init {boxes[film]} --preset {preset} -o {out}", out
    first = f"track turning --at 0={boxes['turning']}"
    yield f"{first} --at 8=70,50,30,20 -o between.csv", "between.csv"
    yield f"{first} --preset ng_delp -o forward.csv", "forward.csv"
    yield "refine turning between.csv --at 11=72,52,30,20 -o refined.csv", "refined.csv"
    yield "smooth track_turning_nummiaro.csv -o smoothed.csv", "smoothed.csv"
    yield "watch street --fps 25 -o watched.csv", "watched.csv"
    yield (
        (
            "watch street --fps 25 --line 80,0,80,119 --zone 20,10,140,10,140,60,20,60 "
            "--events events.jsonl -o counted.csv"
        ),
        "events.jsonl",
    )
    yield "watch street --fps 25 --scale 10 -o ground.csv", "ground.csv"
    yield "watch rig.toml -o rig.csv", "rig.csv"
    yield f"batch 'crossing/' --init {boxes['crossing']} --workers 1 -o batch", "batch"
    for name in FORMATS:
        yield f"convert track_turning_default.csv {name} --video turning --fps 25", name
    yield "draw turning between.csv -o drawn.mp4", "drawn.mp4"
    yield "draw street watched.csv -o drawn_all.mp4", "drawn_all.mp4"


def text_of(made: Path) -> str:
    """Return what is kept of a file or a folder."""
    if made.suffix == ".mp4":
        with open_source(str(made)) as film:
            return "".join(hashlib.sha256(f.pixels.tobytes()).hexdigest() + "\n" for f in film)
    if made.is_dir():
        files = sorted(path for path in made.rglob("*") if path.suffix in (".csv", ".txt"))
        return "".join(f"{path.relative_to(made)}\n{path.read_text('utf-8')}" for path in files)
    return made.read_text("utf-8")


def outputs() -> Iterator[tuple[str, str]]:
    """Yield the name of each output, and its text; run in an empty folder."""
    for line, made in commands(render()):
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            code = main(shlex.split(line))
        if code not in (0, 4):
            sys.exit(f"motes {line}\n{said.getvalue()}")
        yield made, text_of(Path(made))


def made_now() -> dict[str, str]:
    """Return the text of each output by its name."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return dict(outputs())


def kept() -> dict[str, str]:
    """Return the texts that are kept."""
    return {path.name.removesuffix(".txt"): path.read_text("utf-8") for path in KEPT.iterdir()}


if __name__ == "__main__":
    now = made_now()
    if sys.argv[1:] == ["--keep"]:
        shutil.rmtree(KEPT, ignore_errors=True)
        KEPT.mkdir()
        for name, text in now.items():
            (KEPT / f"{name}.txt").write_text(text, encoding="utf-8")
    else:
        before = kept()
        found = sorted(name for name in now | before if now.get(name) != before.get(name))
        sys.exit(f"{len(found)} outputs differ: {', '.join(found)}" if found else None)
