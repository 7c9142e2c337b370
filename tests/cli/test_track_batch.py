"""motes track with several --init, and what it writes for annotators."""

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from clips import write_film
from commands import Go, read_csv, running
from motes import Tracker, open_source
from motes.synthetic.clips import crowd

FRAMES = 6
BOXES = [(60, 40, 20, 30), (120, 50, 24, 24)]
TWO = " ".join(f"--init {','.join(map(str, box))}" for box in BOXES)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    write_film(path, crowd((200, 160), (20, 30), FRAMES))
    return str(path)


@pytest.fixture
def go(film: str, here: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run motes track in an empty folder; FILM in the arguments is the video."""
    return running(capfd, "track", FILM=film)


def test_each_is_followed_as_if_alone(go: Go, film: str) -> None:
    code, out, error = go(f"FILM {TWO} -o r.csv --overlay o.mkv --seed 3")
    assert (code, out) == (0, "")
    assert f"{FRAMES} frames, object 1 tracked in" in error
    assert "wrote o.mkv, r.csv" in error
    rows = read_csv("r.csv")
    assert [(row["frame"], row["id"]) for row in rows] == [
        (str(frame), who) for frame in range(FRAMES) for who in "12"
    ]
    for i, box in enumerate(BOXES):
        tracker = Tracker(seed=3 + i)
        with open_source(film) as source:
            frames = list(source)
        tracks = [tracker.init(frames[0], box), *map(tracker.update, frames[1:])]
        found = np.array(
            [[float(row[c]) for c in ("left", "top", "width", "height")] for row in rows]
        )
        np.testing.assert_allclose(found[i::2], [track.box for track in tracks], atol=6e-4)
    with open_source("o.mkv") as overlay:
        assert sum(1 for _ in overlay) == FRAMES


@pytest.mark.parametrize("boxes", [TWO, TWO[: TWO.index(" --init")]])
def test_documents(go: Go, boxes: str) -> None:
    """Also of one object."""
    count = boxes.count("--init")
    assert go(f"FILM {boxes} -o r.json")[0] == 0
    assert go(f"FILM {boxes} -o r.xml")[0] == 0
    assert go(f"FILM {boxes} -o r.txt")[0] == 0
    document = json.loads(Path("r.json").read_text())
    assert len(document["images"]) == FRAMES
    assert document["annotations"][0]["bbox"] == list(BOXES[0])
    tracks = list(ElementTree.parse("r.xml").getroot().iter("track"))
    assert [track.get("id") for track in tracks] == ["1", "2"][:count]
    rows = np.loadtxt("r.txt", delimiter=",")
    assert (
        len(rows)
        == len(document["annotations"])
        == sum(box.get("outside") == "0" for track in tracks for box in track)
    )
    np.testing.assert_allclose(rows[0, :6], [1, 1, *np.add(BOXES[0], (1, 1, 0, 0))], atol=6e-3)
