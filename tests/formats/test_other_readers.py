"""Files of each format, as the libraries of others read them."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motes.formats import registry, runs
from recordings import crowd, ellipse, turning


def test_cocos_own_tool_reads_masks(tmp_path: Path) -> None:
    """Their runs and ours are the same text, and the same pixels."""
    tool = pytest.importorskip("pycocotools.mask", reason="pycocotools is not installed")
    rng = np.random.default_rng(0)
    for shape in ((1, 1), (7, 5), (48, 64), (300, 2)):
        for share in (0.0, 0.03, 0.5, 1.0):
            mask = rng.random(shape) < share
            theirs = tool.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()
            assert runs.encode(mask) == theirs
            assert (runs.decode(theirs, *shape) == mask).all()
    big = np.zeros((1080, 1920), bool)
    big[200:900, 300:1700] = True
    assert (
        runs.encode(big) == tool.encode(np.asfortranarray(big.astype(np.uint8)))["counts"].decode()
    )


def test_movement_reads_points(tmp_path: Path) -> None:
    poses = pytest.importorskip(
        "movement.io.load_poses",
        reason="movement is not installed: it brings another OpenCV, so try it in an environment "
        "of its own",
    )
    registry.write(tmp_path / "one.csv", "deeplabcut", turning())
    found = poses.from_dlc_file(tmp_path / "one.csv", fps=25)
    center = found.position.sel(keypoints="center").squeeze().values
    assert center.shape == (40, 2)
    np.testing.assert_allclose(center[7], ellipse(7)[:2], atol=1e-3)
    assert np.isnan(center[20:25]).all()
    registry.write(tmp_path / "two.csv", "deeplabcut", crowd())
    found = poses.from_dlc_file(tmp_path / "two.csv", fps=25)
    assert found.sizes["individuals"] == 2
    assert found.sizes["keypoints"] == 3


def test_label_studios_own_tool_takes_the_regions(tmp_path: Path) -> None:
    tool = pytest.importorskip(
        "label_studio_sdk.label_interface",
        reason="label-studio-sdk is not installed: it brings another OpenCV, so try it in an "
        "environment of its own",
    )
    registry.write(tmp_path / "a.ls.json", "label-studio", crowd())
    interface: Any = tool.LabelInterface(
        '<View><Labels name="videoLabels" toName="video"><Label value="car"/>'
        '<Label value="object"/></Labels><Video name="video" value="$video"/>'
        '<VideoRectangle name="box" toName="video"/></View>'
    )
    (task,) = json.loads((tmp_path / "a.ls.json").read_text())
    with contextlib.redirect_stdout(io.StringIO()):
        for prediction in task["predictions"]:
            assert interface.validate_prediction(prediction)
