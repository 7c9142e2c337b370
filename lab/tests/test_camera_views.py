"""The films of the experiment with moving cameras, and its tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crowds import write_crowd
from evaluations import pictures
from motes import Frame
from motes_lab.cli import main
from motes_lab.datasets.mot import load_mot_dataset
from motes_lab.datasets.mot_rows import rows_of
from motes_lab.papers.moving_camera import motion_errors, rows_in, seen, view_of


def test_boxes_are_where_the_view_shows_their_object(tmp_path: Path) -> None:
    crowd = write_crowd(tmp_path / "crowd")
    (sequence,), _ = load_mot_dataset(crowd)
    view = view_of(300, 200, 40, 25, moves=True)
    for index in (0, 13, 29):
        pixels = np.zeros((200, 300, 3), np.uint8)
        pixels[90:110, 140:156] = 255
        (frame,) = seen(view, sequence, [Frame(index, 0.0, pixels)])
        assert frame.pixels.shape == (133, 200, 3)
        row = rows_in(view, rows_of([[index + 1, 7, 141, 91, 16, 20, 1]]))
        ((_, box, _),) = row.listed(index)
        ys, xs = np.nonzero(frame.pixels[:, :, 0] > 127)
        assert xs.mean() == pytest.approx(box.x + (box.width - 1) / 2, abs=0.5)
        assert ys.mean() == pytest.approx(box.y + (box.height - 1) / 2, abs=0.5)
        assert len(xs) == pytest.approx(box.width * box.height, rel=0.06)
    gone = rows_in(view, rows_of([[1, 7, 1, 1, 16, 20, 1]]))
    assert len(gone.ids) == 0


def test_a_true_motion_is_not_off_and_none_is() -> None:
    view = view_of(300, 200, 10, 25, moves=True)
    true = view.places[1:] @ np.linalg.inv(view.places[:-1])
    assert motion_errors(view, list(true)).max() < 1e-9
    still = motion_errors(view, [np.eye(3)] * 9)
    assert still.min() > 0.1
    rest = view_of(300, 200, 10, 25, moves=False)
    assert motion_errors(rest, [np.eye(3)] * 9).max() == 0


@pytest.mark.slow
def test_the_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crowd = write_crowd(tmp_path / "crowd")
    drone = pictures(tmp_path / "drone" / "img", 6).parent
    (drone / "groundtruth_rect.txt").write_text("20,20,10,10\n" * 6)
    out = tmp_path / "out"
    assert main(["experiment", "moving-camera", str(crowd), str(drone), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    for part in ("similarity", "homography", "given, moves, followed", "mog2, at rest", "drone"):
        assert part in text
    assert (out / "moving-camera-identities.csv").exists()
