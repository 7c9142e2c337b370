"""Metrics against hand-worked examples, sequences in OTB's layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motes.errors import ConfigError, FormatError
from motes.evaluate.metrics import calibration_error, detection_f1, success_auc
from motes.evaluate.peers import PEERS, peer
from motes.evaluate.sequences import load_otb
from motes.synthetic import still


@pytest.mark.parametrize(
    ("overlaps", "auc"),
    [
        ([1.0], 20 / 21),  # exceeds every threshold but 1
        ([0.0], 0.0),
        ([0.5], 10 / 21),  # 0, 0.05 … 0.45
        ([0.51, 0.0], 11 / 42),
        ([1.0, 0.5, 0.0], (20 + 10) / 63),
    ],
)
def test_success_auc(overlaps: list[float], auc: float) -> None:
    assert success_auc(np.array(overlaps)) == pytest.approx(auc)


def test_detection_f1() -> None:
    said = np.array([True, True, True, False, False])
    true = np.array([True, False, True, True, False])
    assert detection_f1(said, true) == pytest.approx(2 / 3)  # precision 2/3, recall 2/3
    assert detection_f1(~true, true) == 0
    assert detection_f1(np.zeros(3, bool), np.zeros(3, bool)) == 1


def test_calibration_error() -> None:
    # Bin 0.9 to 1: mean confidence 0.95, half right. Bin 0.2 to 0.3: 0.2, none right.
    confidence = np.array([0.9, 1.0, 0.2, 0.2])
    correct = np.array([True, False, False, False])
    assert calibration_error(confidence, correct, np.ones(4)) == pytest.approx(
        (2 * 0.45 + 2 * 0.2) / 4
    )
    weights = np.array([1.0, 1.0, 0.0, 0.0])
    assert calibration_error(confidence, correct, weights) == pytest.approx(0.45)
    assert calibration_error(np.array([0.0, 1.0]), np.array([False, True]), np.ones(2)) == 0


@pytest.mark.parametrize(
    "line", ["11,21,30,40", "11\t21\t30\t40", "11 21  30 40", " 11, 21, 30, 40 "]
)
def test_otb_layout(tmp_path: Path, line: str) -> None:
    (tmp_path / "groundtruth_rect.txt").write_text(f"{line}\n\nNaN,NaN,NaN,NaN\n")
    sequence = load_otb(tmp_path)
    assert sequence.name == tmp_path.name
    assert sequence.source == tmp_path / "img"
    np.testing.assert_array_equal(sequence.boxes, [[10, 20, 30, 40], [np.nan] * 4])
    np.testing.assert_array_equal(load_otb(tmp_path, first_pixel=0).boxes[0], [11, 21, 30, 40])


@pytest.mark.parametrize("text", [None, "", "1,2,3", "1,2,3,4\n1,2,3,4,5", "a,b,c,d"])
def test_truth_that_is_none(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "groundtruth_rect.txt").write_text(text)
    with pytest.raises(FormatError, match="groundtruth_rect"):
        load_otb(tmp_path)


@pytest.mark.parametrize("name", PEERS)
def test_peers_follow(name: str) -> None:
    pytest.importorskip("cv2")
    clip = still((320, 240), target=(40, 60), frames=4)
    box = [round(value) for value in clip[0][1][0].ellipse.box]
    tracker = peer(name)
    tracker.init(clip[0][0].pixels[:, :, ::-1].copy(), box)
    found, place = tracker.update(clip[1][0].pixels[:, :, ::-1].copy())
    assert found
    assert abs(place[0] + place[2] / 2 - box[0] - box[2] / 2) < 20


def test_unknown_peer() -> None:
    with pytest.raises(ConfigError, match="known are cv2:csrt"):
        peer("cv2:nothing")
