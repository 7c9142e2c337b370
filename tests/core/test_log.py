"""The logger `motes`: what a program may hear, and that it hears nothing unasked."""

import logging
from pathlib import Path

import numpy as np
import pytest

import motes

PIXELS = np.random.default_rng(0).integers(0, 255, (72, 96, 3), np.uint8)


def test_changes_of_status_and_warnings_are_logged(
    caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    caplog.set_level(logging.INFO, "motes")
    tracker = motes.Tracker("nummiaro")
    tracker.init(PIXELS, (20, 20, 20, 20))
    while tracker.info.track.status is motes.Status.TRACKING:
        tracker.update(np.zeros_like(PIXELS))
    lost = tracker.info.track.frame
    scene = motes.Scene(lambda frame: [(30 + frame.index, 20, 20, 20), (np.nan, 1, 9, 9)])
    for _ in range(4):
        scene.update(PIXELS)
    path = tmp_path / "film.mp4"
    with motes.VideoWriter(path, fps=25) as writer:
        for turn in range(30):
            writer.write(np.roll(PIXELS, 7 * turn))
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 4000] = bytes(4000)
    path.write_bytes(data)
    with motes.open_source(str(path)) as frames:
        list(frames)
        problems = frames.report.problems
    said = [(record.levelname, record.getMessage()) for record in caplog.records]
    assert said[:2] == [
        ("INFO", "Frame 0: the target is tracking."),
        ("INFO", f"Frame {lost}: the target is lost."),
    ]
    assert ("INFO", "Frame 2: object 1 is tracking.") in said
    assert said.count(("WARNING", scene.warnings["broken"])) == 1
    assert problems is not None
    assert said.count(("WARNING", f"{path}: {problems}.")) == 1
    caplog.clear()
    motes.correct(path, {0: (20, 20, 20, 20)}, "nummiaro")
    assert f"{path}: {problems}." in [record.getMessage() for record in caplog.records]
