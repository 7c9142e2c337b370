"""Folders of `motes-lab evaluate` that are resumed: their record, and their tracks."""

from typing import Any

import msgspec
import numpy as np

from motes.core.geometry import Box, Ellipse
from motes_lab.adapters.registry import tracker_spec
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.mot_rows import read_rows
from motes_lab.datasets.sot import Sequence
from motes_lab.mot_scores import MotOutcome
from motes_lab.protocols.mot import Tracks, save_tracks
from motes_lab.protocols.sot import Start
from motes_lab.protocols.trace import TrackerOutput, save_trace
from motes_lab.run_folder import RECORD, Record, prepare
from motes_lab.runner import Job, Pass
from motes_lab.scores import Outcome, PassResult

from . import detections
from .outcomes import READ, REFUSED, check_finite, check_message, outcome, put, scratch

FRAMES = detections.FRAMES
NOW = Record(
    motes="0.1.0",
    dataset="/data",
    sequences={"One": "12ab"},
    trackers={"nummiaro": "particles = 100\n"},
    protocols=("ope",),
    seeds=5,
    time_limit=1800.0,
)


def records() -> list[bytes]:
    now = msgspec.json.encode(NOW)
    return [msgspec.json.format(now), now.replace(b"12ab", b"34cd"), now.replace(b"ope", b"pixel")]


def check_record(data: bytes) -> str:
    """Resume an evaluation with a record: it is continued, or refused and stays as it is."""
    path = put(f"resumed/{RECORD}", data)
    found = outcome(lambda: prepare(path.parent, NOW, resume=True))
    if found == REFUSED:
        assert path.read_bytes() == data, "It was changed."
    else:
        assert msgspec.json.decode(path.read_bytes(), type=Record).sequences["One"] == "12ab"
    return found


def traces() -> list[bytes]:
    boxes = np.array([Ellipse.from_box(Box(10 + i, 12, 20, 15.5)) for i in range(FRAMES)])
    path, flags = scratch() / "trace.csv", np.arange(FRAMES) == 3
    times, spread = np.full(FRAMES, 0.002), np.tile((2.0, 0.1, 1.0), (FRAMES, 1))
    confidence = np.linspace(0.1, 0.9, FRAMES)
    save_trace(path, TrackerOutput(np.arange(FRAMES), boxes, confidence, flags, times, spread))
    whole = path.read_bytes()
    return [whole, whole.replace(b"0.002", b"").replace(b"2.0,0.1,1.0", b",,")]


def check_trace(data: bytes) -> str:
    """Resume an evaluation of one object that has this track."""
    boxes = np.array([(10.0 + i, 12, 20, 15.5) for i in range(FRAMES)])
    ellipses = np.array([Ellipse.from_box(Box(*box)) for box in boxes.tolist()])
    sequence, start = Sequence("One", "One", boxes, ellipses), Box(*boxes[0].tolist())
    item = Pass("nummiaro", "One", Start("ope", "", 0, start), 0)
    return _resumed(Outcome, sequence, [item], {"": data})


def tracks() -> list[bytes]:
    path = scratch() / "tracks.csv"
    rows = read_rows(put("truth.txt", detections.TRUTH), FRAMES, "results")
    save_tracks(path, Tracks(rows, np.linspace(0.01, 0.02, FRAMES)))
    whole = path.read_bytes()
    return [whole, whole.replace(b"0.02", b"")]


def check_tracks(data: bytes) -> str:
    """Resume an evaluation of many objects whose track has these times."""
    return _crowd({"": data, ".txt": detections.TRUTH})


def check_track_rows(data: bytes) -> str:
    """Resume an evaluation of many objects whose track has these rows."""
    return _crowd({"": tracks()[0], ".txt": data})


def _crowd(files: dict[str, bytes]) -> str:
    truth = read_rows(put("truth.txt", detections.TRUTH), FRAMES, "truth")
    crowd = MotSequence("One", "One", FRAMES, 25.0, truth, None)
    return _resumed(
        MotOutcome, crowd, [Pass("motes:scene", "One", Start("mot", "", 0, None), 0)], files
    )


def _resumed(
    kind: type[PassResult[Any, Any]],
    where: Sequence | MotSequence,
    passes: list[Pass],
    files: dict[str, bytes],
) -> str:
    """Return what comes of passes in a folder that has these files for each, by ending."""
    out = scratch() / "evaluation"
    for item in passes:
        for ending, data in files.items():
            path = item.path(out)
            path.parent.mkdir(parents=True, exist_ok=True)
            (path.with_suffix(ending) if ending else path).write_bytes(data)
    read = False
    for ended in kind.of(Job((tracker_spec("nummiaro"),), where, tuple(passes)), out, {}):
        if ended.trace is None:
            check_message(ended.error)
        else:
            read = True
            check_finite(ended.scores.values())
    return READ if read else REFUSED
