"""What a type checker says of code that uses motes as its pages show: nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import cv2
import numpy as np

import motes

# The one-line swap: tracker = cv2.TrackerCSRT.create()
tracker = motes.OpenCVTracker.create()
capture = cv2.VideoCapture("film.mp4")
ok, image = capture.read()
tracker.init(image, cv2.selectROI("frame", image))
ok, box = tracker.update(image)
cv2.rectangle(image, box[:2], (box[0] + box[2], box[1] + box[3]), (0, 255, 0))

boxes = np.array([[300.0, 200.0, 40.0, 60.0]])
one = motes.Tracker()
one.init(image, boxes[0])
one.correct(boxes[0])
with motes.Trackers(bgr=True) as several:
    several.init(image, boxes)
    several.add(boxes[0])
    several.save("saved")
tracks = motes.correct("film.mp4", {0: boxes[0], 9: (1, 2, 30, 40), 12: None})


def rows(picture: motes.Frame) -> list[tuple[float, float, float, float, float]]:
    return [(10.0, 20.0, 30.0, 40.0, 0.9)]


def found(frame: motes.Frame) -> list[motes.Detection]:
    return [motes.Detection((10, 20, 30, 40), 0.9), motes.Detection(boxes[0])]


for detector in (rows, found):
    motes.Scene(detector).update(image)
motes.Scene(lambda frame: boxes)
one.detect(image, rows)
with motes.VideoWriter("drawn.mp4", fps=25) as video:
    video.write(motes.draw(image, one.update(image), trail=boxes[:, :2]))
    video.write(motes.draw_scene(image, [], {}))
"""


@pytest.mark.slow
def test_code_of_a_user_has_types(tmp_path: Path) -> None:
    pytest.importorskip("cv2")
    pytest.importorskip("mypy")
    script = tmp_path / "program.py"
    script.write_text(CODE)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(script)],
        capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    assert done.stdout.startswith("Success: no issues found"), done.stdout
