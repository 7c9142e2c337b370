"""`motes draw --masks`: the pixels of a cross, in a folder and in a document."""

import errno
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from commands import Tell
from motes.cli import main
from motes.formats import masks

SIZE = (120, 160)
TRACK = "track film --init 40,40,41,41 --preset mean_shift -o rows.csv"
DRAW = "draw film rows.csv --masks"


def shape(x: float) -> np.ndarray:
    """Return the mask of a cross, which no ellipse fits."""
    v, u = np.mgrid[: SIZE[0], : SIZE[1]] - np.array([60, x])[:, None, None]
    cross: np.ndarray = (np.minimum(abs(u), abs(v)) <= 7) & (np.maximum(abs(u), abs(v)) <= 20)
    return cross


def picture(x: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    colors = np.where(shape(x)[..., None], (200, 60, 40), (60, 90, 150))
    noisy: np.ndarray = np.clip(colors + rng.normal(0, 12, colors.shape), 0, 255)
    return noisy.astype(np.uint8)


@pytest.fixture
def go(here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in a folder with a film of six images."""
    Path("film").mkdir()
    for i in range(6):
        Image.fromarray(picture(60 + 3 * i, i)).save(f"film/{i}.png")
    assert main(TRACK.split()) == 0
    return Tell(capfd)


def overlap(mask: np.ndarray, x: float) -> float:
    return float((mask & shape(x)).sum() / (mask | shape(x)).sum())


def test_a_folder_and_a_document(go: Tell) -> None:
    go.says(f"{DRAW} masks", 0, "wrote masks.")
    assert sorted(path.name for path in Path("masks").iterdir()) == [f"{i}.png" for i in range(6)]
    with Image.open("masks/5.png") as image:
        found = np.asarray(image) > 0
    assert overlap(found, 75) > 0.8
    go.says(f"{DRAW} masks.json --label cross", 0, "wrote masks.json.")
    document = json.loads(Path("masks.json").read_text())
    last = document["annotations"][-1]
    assert last["segmentation"]["size"] == list(SIZE)
    assert (masks.decode(last["segmentation"]["counts"], *SIZE) == found).all()
    assert last["area"] == found.sum()
    assert document["categories"][0]["name"] == "cross"
    assert go("convert masks.json again.json")[0] == 0
    again = json.loads(Path("again.json").read_text())
    assert again["annotations"][-1]["segmentation"] == last["segmentation"]


def test_no_option_is_named_that_draw_does_not_have(go: Tell) -> None:
    head, first, *rest = Path("rows.csv").read_text().splitlines()
    values = dict(zip(head.split(","), first.split(","), strict=True)) | {"confidence": "0.3"}
    Path("rows.csv").write_text("\n".join([head, ",".join(values.values()), *rest, ""]))
    go.says(f"{DRAW} masks", 0, "; 1 guess left out (interpolated, or confidence below 0.5).")


def test_a_full_disk_keeps_the_rows_of_the_masks(go: Tell, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = list[int]()

    def full(file: int) -> None:
        calls.append(file)
        if len(calls) == 4:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    go.says(f"{DRAW} masks", 5, "its rows are kept in masks.rows.jsonl")
    assert not [*Path().glob("masks*/")]
    assert go("convert masks.rows.jsonl masks")[0] == 0
    assert sorted(path.name for path in Path("masks").iterdir()) == [f"{i}.png" for i in range(6)]


def test_masks_are_made_of_a_document_and_of_ellipses(go: Tell) -> None:
    assert go(f"{DRAW} masks.json")[0] == go("convert masks.json again --to masks")[0] == 0
    assert go(f"{DRAW} masks")[0] == 0
    for path in Path("masks").iterdir():
        assert Path("again", path.name).read_bytes() == path.read_bytes()
    assert go("convert rows.csv ellipses --to masks --size 160x120")[0] == 0
    with Image.open("ellipses/frame_000000.png") as image:
        white = np.asarray(image) > 0
    assert white.sum() == pytest.approx(np.pi * 20.5**2, rel=0.02)
    go.says("convert masks a.csv", 2, "masks is only written")


@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("film", 2, "film is the source"),
        ("full", 5, "full has files; choose another"),
        ("a.mp4", 2, "--masks a.mp4: give a folder for PNG files, or a .json"),
        ("m --label cross", 2, "--label is for masks in a document, as .json; omit it."),
    ],
)
def test_errors_are_one_line(go: Tell, line: str, code: int, message: str) -> None:
    Path("full").mkdir()
    Path("full/a").touch()
    go.says(f"{DRAW} {line}", code, message, lines=1)
