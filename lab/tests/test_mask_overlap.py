"""`motes-lab experiment masks`: true masks, or boxes around masks, beside those of GrabCut."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motes_lab.cli import main
from motes_lab.mask_overlap import box_of

FRAMES, SIZE = 4, (90, 120)


def cross(x: int) -> np.ndarray:
    """Return the mask of a cross, which no ellipse fits."""
    v, u = np.mgrid[: SIZE[0], : SIZE[1]] - np.array([45, x])[:, None, None]
    mask: np.ndarray = (np.minimum(abs(u), abs(v)) <= 6) & (np.maximum(abs(u), abs(v)) <= 18)
    return mask


@pytest.fixture
def sequence(tmp_path: Path) -> Path:
    """Return the folder of a sequence with a true mask for each frame."""
    folder = tmp_path / "data" / "crosses"
    for name in ("img", "masks"):
        (folder / name).mkdir(parents=True)
    rng, boxes = np.random.default_rng(0), []
    for i in range(FRAMES):
        mask = cross(50 + 2 * i)
        colors = np.where(mask[..., None], (200, 60, 40), (60, 90, 150))
        noisy = np.clip(colors + rng.normal(0, 12, colors.shape), 0, 255).astype(np.uint8)
        Image.fromarray(noisy).save(folder / "img" / f"{i + 1:04}.png")
        Image.fromarray(mask.astype(np.uint8) * 255).save(folder / "masks" / f"{i + 1:04}.png")
        boxes.append(box_of(mask))
    rows = [f"{x + 1},{y + 1},{width},{height}" for x, y, width, height in boxes]
    (folder / "groundtruth_rect.txt").write_text("\n".join(rows) + "\n")
    return folder


def run(sequence: Path, out: Path) -> int:
    line = f"experiment masks {sequence.parent} --every 2 --out {out}"
    return main(line.split())


def means(path: Path) -> dict[str, float]:
    with path.open() as file:
        (row, *_) = csv.DictReader(file)
    return {name: float(row[name]) for name in ("tracked ellipse", "motes", "GrabCut")}


def test_masks_are_compared_with_true_ones(sequence: Path, tmp_path: Path) -> None:
    assert run(sequence, tmp_path / "out") == 0
    pixels, boxes = (means(tmp_path / "out" / f"masks-{n}.csv") for n in ("masks", "boxes"))
    assert pixels["motes"] > 0.8 > pixels["tracked ellipse"]
    assert boxes["motes"] > 0.9
    assert min(pixels["GrabCut"], boxes["GrabCut"]) > 0.6


def test_without_masks_boxes_are_compared(sequence: Path, tmp_path: Path) -> None:
    for path in (sequence / "masks").iterdir():
        path.unlink()
    (sequence / "masks").rmdir()
    assert run(sequence, tmp_path / "out") == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "masks-boxes.csv", "masks.md",
    ]  # fmt: skip


def test_wrong_masks_are_named(
    sequence: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def said() -> str:
        capsys.readouterr()
        assert run(sequence, tmp_path / "out") == 3
        return capsys.readouterr().err

    third = sequence / "masks" / "0003.png"
    Image.fromarray(np.zeros((9, 9), np.uint8)).save(third)
    assert "0003.png has 9x9 pixels, its frame 120x90" in said()
    third.write_text("no picture")
    assert "0003.png cannot be read" in said()
    third.unlink()
    assert "has 3 masks for 4 frames; give one for each" in said()
