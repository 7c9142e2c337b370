"""A detector of faces that is trained on pictures of one's own."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motes import cli
from motes.core.errors import ConfigError, MissingDependencyError, SourceError
from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.core.types import Bytes
from motes.mot.detection.pretrained import FaceDetector, FacesConfig
from motes_lab.cli import main
from motes_lab.face_training import Example, read_examples, train_faces

SIZE = 84


def drawn(seed: int) -> tuple[Bytes, Box]:
    """Return a picture of gray blocks with a round face of two eyes and a mouth, and its box."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(60, 200, (12, 16, 3)).repeat(14, 0).repeat(14, 1).astype(np.uint8)
    y, x = int(rng.integers(4, 80)), int(rng.integers(4, 130))
    row, column = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    face = picture[y : y + SIZE, x : x + SIZE]
    face[np.hypot(row, column) < SIZE / 2] = (220, 180, 150)
    for eye in (22, 52):
        face[28:38, eye : eye + 10] = 20
    face[58:65, 24:60] = (120, 20, 20)
    return picture, Box(x, y, SIZE, SIZE)


def pictures(folder: Path, lines: list[str]) -> Path:
    for seed in range(5):
        picture, box = drawn(seed)
        Image.fromarray(picture).save(folder / f"{seed}.png")
        lines.append(f"{seed}.png,{box.x},{box.y},{box.width},{box.height}")
    (folder / "faces.csv").write_text("\n".join(lines) + "\n")
    return folder / "faces.csv"


@pytest.mark.slow
def test_a_trained_detector_finds_such_faces(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("dlib", reason="faces need dlib")
    empty = np.random.default_rng(9).integers(0, 255, (90, 120, 3), np.uint8)
    Image.fromarray(empty).save(tmp_path / "empty.png")
    table = pictures(tmp_path, ["picture,x,y,width,height", "empty.png", ""])
    model = tmp_path / "faces.svm"
    assert main(["faces", "train", str(table), "-o", str(model)]) == 0
    said = capsys.readouterr().err
    assert "from 5 faces in 6 pictures; of these it finds 100%, and 100% of what" in said
    picture, box = drawn(50)
    usual, trained = FaceDetector(), FacesConfig(model=str(model)).detector()
    assert usual(Frame(0, 0.0, picture)) == []
    [found] = trained(Frame(0, 0.0, picture))
    assert iou(found.box, box) > 0.6
    assert main(["faces", "train", str(table), "-o", str(model)]) == 5

    Image.fromarray(picture).save(tmp_path / "shown.png")
    line = ["track", str(tmp_path / "shown.png"), "--detect", "face", "-o"]
    assert cli.main([*line, str(tmp_path / "none.csv")]) == 4
    assert cli.main([*line, str(tmp_path / "found.csv"), "--face-model", str(model)]) == 0


def test_files_that_are_no_faces(tmp_path: Path) -> None:
    table = pictures(tmp_path, [])
    assert len(read_examples(table)) == 5
    for text, message in (
        ("0.png,1,2,3", "line 1, is not a face: picture,x,y,width,height; got"),
        ("0.png,1,2,3,x", "line 1, is not a face"),
        ("0.png,1,2,0,9", "line 1, is not a face"),
        ("0.png,nan,2,9,9", "line 1, is not a face"),
        ("none.png,1,2,9,9", "none.png"),
        ("", "names no picture"),
    ):
        table.write_text(text)
        with pytest.raises(SourceError, match=message):
            read_examples(table)
    with pytest.raises(SourceError, match="cannot be read"):
        read_examples(tmp_path / "none.csv")


def test_what_dlib_cannot_learn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("dlib", reason="faces need dlib")
    picture, _ = drawn(0)
    with pytest.raises(ConfigError, match="no face in the pictures"):
        train_faces([Example(picture, ())], tmp_path)
    with pytest.raises(ConfigError, match=r"dlib cannot learn these boxes .* of about one shape"):
        train_faces([Example(picture, (Box(0, 0, 4, 90),))], tmp_path)
    (tmp_path / "text").write_text("hello")
    for name in ("text", "none"):
        with pytest.raises(SourceError, match=f"{name} is not a detector of faces; make one with"):
            FacesConfig(model=str(tmp_path / name)).detector()
    monkeypatch.setitem(sys.modules, "dlib", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motes\[faces\]'"):
        train_faces([Example(picture, ())], tmp_path)
