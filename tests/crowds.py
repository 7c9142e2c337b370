"""Truth and results with many objects, and what TrackEval makes of them."""

import contextlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evaluations import pictures
from motes.formats.mot import UNKNOWN
from motes_lab.datasets.mot_rows import MotRows, rows_of
from motes_lab.metrics.mot import Tally

FIELDS: Mapping[str, tuple[str, str]] = {
    "hits": ("HOTA", "HOTA_TP"),
    "hota": ("HOTA", "HOTA"),
    "deta": ("HOTA", "DetA"),
    "assa": ("HOTA", "AssA"),
    "loca": ("HOTA", "LocA"),
    "mota": ("CLEAR", "MOTA"),
    "motp": ("CLEAR", "MOTP"),
    "matches": ("CLEAR", "CLR_TP"),
    "false_positives": ("CLEAR", "CLR_FP"),
    "false_negatives": ("CLEAR", "CLR_FN"),
    "switches": ("CLEAR", "IDSW"),
    "fragmentations": ("CLEAR", "Frag"),
    "mostly_tracked": ("CLEAR", "MT"),
    "mostly_lost": ("CLEAR", "ML"),
    "identified": ("Identity", "IDTP"),
    "idf1": ("Identity", "IDF1"),
    "idp": ("Identity", "IDP"),
    "idr": ("Identity", "IDR"),
}
"""What a tally has, and its name in TrackEval."""

TRACKERS = '''
"""Trackers of many objects that a test evaluates."""

from motes import Box, Detection


class Echo:
    """Says what it is told, numbered from the left."""

    def __init__(self, info):
        assert info.name in ("film", "a", "b")
        assert (info.frames, info.rate, info.width, info.height) == (12, 25, 160, 120)
        self.seed = 0

    def update(self, frame, detections):
        assert frame.pixels.shape == (120, 160, 3)
        boxes = sorted(each.box for each in detections)
        frame.pixels[:] = 0  # as some do; the next pass shall not see it
        return [(i, (x + self.seed, *box), 0.5) for i, (x, *box) in enumerate(boxes)]


class Seeded(Echo):
    def __init__(self, info, seed):
        super().__init__(info)
        self.seed = seed


class Raises(Echo):
    def update(self, frame, detections):
        if frame.index == 6:
            raise ValueError("no more\\nof this")
        return super().update(frame, detections)


class Blind:
    value = None

    def __init__(self, info):
        pass

    def update(self, frame, detections):
        return [(0, (1, 2, 3, 4), 0)] if detections is None else Blind.value


def useless(info):
    return 3


class Corner:
    """A detector."""

    def __call__(self, frame):
        return [Detection(Box(frame.index, 2, 3, 4), 0.25)]


class Nothing:
    """Another one."""

    def __call__(self, frame):
        assert frame.pixels.any()
        return []
'''


def trackeval() -> Any:
    """Return the module; it says what it cannot import, which does not matter here."""
    with contextlib.redirect_stdout(io.StringIO()):
        return pytest.importorskip(
            "trackeval", reason="TrackEval is not installed; `make test` installs it"
        )


def _metrics() -> list[Any]:
    metrics, quiet = trackeval().metrics, {"PRINT_CONFIG": False}
    return [metrics.HOTA(), metrics.CLEAR(quiet), metrics.Identity(quiet)]


def theirs(truth: MotRows, results: MotRows, frames: int, rules: str = "MOT15") -> dict[str, Any]:
    """Return TrackEval's numbers by metric, its own choice of what counts included."""
    dataset = trackeval().datasets.MotChallenge2DBox.__new__(trackeval().datasets.MotChallenge2DBox)
    names = (
        "pedestrian", "person_on_vehicle", "car", "bicycle", "motorbike", "non_mot_vehicle",
        "static_person", "distractor", "occluder", "occluder_on_ground", "occluder_full",
        "reflection", "crowd",
    )  # fmt: skip
    dataset.benchmark, dataset.do_preproc = rules, True
    dataset.class_name_to_class_id = {name: i for i, name in enumerate(names, 1)}
    dataset.valid_class_numbers = list(range(1, 14))
    there = [truth.at(frame) for frame in range(1, frames + 1)]
    said = [results.at(frame) for frame in range(1, frames + 1)]
    raw = {
        "num_timesteps": frames,
        "seq": "film",
        "gt_ids": [truth.ids[rows] for rows in there],
        "gt_dets": [truth.boxes[rows] for rows in there],
        "gt_classes": [truth.classes[rows] for rows in there],
        "gt_extras": [{"zero_marked": truth.scores[rows].astype(int)} for rows in there],
        "tracker_ids": [results.ids[rows] for rows in said],
        "tracker_dets": [results.boxes[rows] for rows in said],
        "tracker_classes": [np.ones(len(results.ids[rows]), int) for rows in said],
        "tracker_confidences": [results.scores[rows] for rows in said],
        "similarity_scores": [
            dataset._calculate_similarities(truth.boxes[i], results.boxes[j])
            for i, j in zip(there, said, strict=True)
        ],
    }
    return evaluated(dataset, raw)


def evaluated(dataset: Any, raw: dict[str, Any]) -> dict[str, Any]:
    data = dataset.get_preprocessed_seq_data(raw, "pedestrian")
    return {metric.get_name(): metric.eval_sequence(data) for metric in _metrics()}


def combined(sequences: list[dict[str, Any]]) -> dict[str, Any]:
    """Return TrackEval's numbers of several sequences."""
    return {
        (name := metric.get_name()): metric.combine_sequences(
            {str(i): sequence[name] for i, sequence in enumerate(sequences)}
        )
        for metric in _metrics()
    }


def from_files(truth: Path, results: Path, sequence: str) -> dict[str, Any]:
    """Return what TrackEval reads in TRUTH/SEQUENCE/gt/gt.txt and RESULTS/SEQUENCE.txt."""
    dataset = trackeval().datasets.MotChallenge2DBox(
        {
            "GT_FOLDER": str(truth),
            "TRACKERS_FOLDER": str(results.parent),
            "TRACKERS_TO_EVAL": [results.name],
            "TRACKER_SUB_FOLDER": "",
            "SEQ_INFO": {sequence: None},
            "SKIP_SPLIT_FOL": True,
            "BENCHMARK": "MOT15",
            "PRINT_CONFIG": False,
        }
    )
    return evaluated(dataset, dataset.get_raw_seq_data(results.name, sequence))


def assert_equal(ours: Tally, other: dict[str, Any]) -> None:
    """Check all numbers, to 1e-9."""
    for name, (metric, field) in FIELDS.items():
        np.testing.assert_allclose(
            getattr(ours, name), other[metric][field], rtol=0, atol=1e-9, err_msg=name
        )


def rows(*lines: tuple[float, ...]) -> MotRows:
    """Return rows of frame, id, x, y, width, height, and maybe score and class."""
    return rows_of([[*line, *(1.0, UNKNOWN)[len(line) - 6 :]] for line in lines])


def write_crowd(folder: Path, shift: float = 0.0, frames: int = 12) -> Path:
    """Make a sequence in which two objects move, and detections that are `shift` pixels off."""
    pictures(folder / "img1", frames, (160, 120))
    objects = [
        (f, i, 20 + 40 * i + 2 * f, 30.0, 20.0, 40.0) for f in range(1, frames + 1) for i in (1, 2)
    ]
    (folder / "seqinfo.ini").write_text(f"[Sequence]\nframeRate=25\nseqLength={frames}\n")
    for name, lines in (
        ("gt", [(f, i, *box, 1, 1, 1) for f, i, *box in objects]),
        ("det", [(f, -1, x + shift, *box, 0.9) for f, _, x, *box in objects]),
    ):
        (folder / name).mkdir()
        text = "".join(",".join(map(str, line)) + "\n" for line in lines)
        (folder / name / f"{name}.txt").write_text(text)
    return folder


def perturbed(rng: np.random.Generator, truth: MotRows, frames: int) -> MotRows:
    """Return results that are about right: shifted, with gaps, swapped identities, and clutter."""
    kept = rng.random(len(truth.ids)) < 0.85
    boxes = truth.boxes + rng.normal(0, 0.06, truth.boxes.shape) * truth.boxes[:, [2, 3, 2, 3]]
    ids = truth.ids.copy()
    for frame in rng.integers(2, frames, 6):
        one, other = rng.choice(np.unique(truth.ids), 2, replace=False)
        later = truth.frames >= frame
        swapped = {one: other, other: one}
        ids[later] = [swapped.get(identity, identity) for identity in ids[later]]
    clutter = 200
    places = boxes[rng.integers(len(boxes), size=clutter)] + rng.uniform(-80, 80, (clutter, 4))
    places[:, 2:] = np.abs(places[:, 2:]) + 5
    lines = [
        *zip(truth.frames[kept], ids[kept], *boxes[kept].T, strict=True),
        *zip(
            rng.integers(1, frames + 1, clutter), 900 + np.arange(clutter), *places.T, strict=True
        ),
    ]
    return rows(*(tuple(map(float, line)) for line in lines))
