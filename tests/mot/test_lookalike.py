"""All that look like one."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, iou
from motes.mot.detection.lookalike import LIMIT, LookalikeConfig, LookalikeDetector
from motes.mot.scene import Scene
from motes.mot.scene_config import named_detector
from motes_lab.papers.zhao_pei_team import Team, team as follow_team

RED, BLUE, WHITE, LAWN = (200, 30, 30), (40, 50, 160), (235, 235, 235), (60, 120, 40)
SIZE = 14, 30


def pitch(index: int, *players: tuple[int, int, tuple[int, int, int]]) -> Frame:
    """Return a striped lawn with players of one color, each at x, y, on black legs."""
    rng = np.random.default_rng(index)
    pixels = np.full((180, 320, 3), LAWN, np.int16)
    pixels[:, ::40] += 30
    pixels[90:93] = WHITE  # a line across
    for x, y, shirt in players:
        pixels[y : y + 18, x : x + 14] = shirt
        pixels[y + 18 : y + 30, x + 3 : x + 11] = (20, 20, 20)
    pixels += rng.integers(-8, 9, pixels.shape, np.int16)
    return Frame(index, index / 25, pixels.clip(0, 255).astype(np.uint8))


TEAM = [(30, 20), (100, 120), (200, 40), (270, 130)]
OTHERS = [(60, 60), (150, 20), (240, 90)]


def test_a_team_is_found_and_the_others_are_not() -> None:
    frame = pitch(
        0, *((x, y, BLUE) for x, y in TEAM), *((x, y, WHITE) for x, y in OTHERS), (160, 130, RED)
    )
    found = LookalikeDetector((*TEAM[0], *SIZE))(frame)
    assert len(found) == len(TEAM)
    for x, y in TEAM:
        overlaps = [float(iou((x, y, *SIZE), each.box)) for each in found]
        assert max(overlaps) > 0.5, (x, y)
    assert {each.score for each in found} == {1.0}


def test_where_everything_is_alike_there_is_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each place of a grid of thousands was looked at, for many seconds."""
    looks: list[Ellipse] = []
    look = LookalikeDetector._apart

    def counted(self: LookalikeDetector, frame: Frame, place: Ellipse) -> float:
        looks.append(place)
        return look(self, frame, place)

    monkeypatch.setattr(LookalikeDetector, "_apart", counted)
    frame = Frame(0, 0.0, np.full((90, 160, 3), 90, np.uint8))
    assert len(LookalikeDetector((20, 20, 8, 8))(frame)) <= LIMIT
    assert len(looks) == LIMIT


def test_nonsense_is_refused_at_once() -> None:
    frame, box = pitch(0), (*TEAM[0], *SIZE)
    with pytest.raises(ConfigError, match=r"A region is x,y,width,height .*; got Frame"):
        LookalikeDetector(frame, box)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=r"A detector is a callable from a Frame .*; got Frame"):
        LookalikeDetector(box, frame)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="4 numbers"):
        LookalikeDetector(box[:3])


def test_of_what_another_detector_finds_the_alike_are_kept(tmp_path: Path) -> None:
    frame = pitch(0, *((x, y, BLUE) for x, y in TEAM), *((x, y, WHITE) for x, y in OTHERS))
    lines = [f"1,-1,{x + 1},{y + 1},14,30,1" for x, y in [*TEAM[:3], *OTHERS]]
    (tmp_path / "det.txt").write_text("\n".join(lines))
    like = LookalikeConfig((*TEAM[0], *SIZE))
    found = LookalikeDetector(like, named_detector(str(tmp_path / "det.txt")))(frame)
    assert len(found) == 3
    for x, y in TEAM[:3]:
        assert max(float(iou((x, y, *SIZE), each.box)) for each in found) > 0.5


@pytest.mark.parametrize("speed", [0, 2])
def test_counts_are_in_doubt_where_the_camera_moves_alone(speed: int) -> None:
    """The detector finds a motion of the camera in every frame, which is none at speed 0."""
    scene = Scene(LookalikeDetector((30, 20, *SIZE)), seed=0)
    wide = np.kron(np.random.default_rng(0).integers(90, 150, (30, 60, 3)), np.ones((8, 8, 1)))
    for index in range(4):
        pixels = wide[:180, speed * index : speed * index + 320].astype(np.uint8)
        pixels[20:50, 30:44] = RED
        scene.update(Frame(index, index / 25, pixels))
    assert scene.doubts == ({"camera": 1} if speed else {})


@pytest.mark.slow
def test_the_players_of_a_team_are_followed(data: Path) -> None:
    """Boxes by hand in the first four of twelve frames of a film whose camera pans."""
    marked = Team.load(Path(__file__).parents[2] / "lab/tests/truth/team.toml")
    marked = replace(marked, frame=marked.frame[:4])
    *_, result = follow_team(marked, data / "sot" / marked.sequence / "img")
    (table,) = result.tables.values()
    objects, _, _, precision, recall = (cell.value or 0 for cell in table.foot[0][1:])
    assert objects == 19
    assert precision >= 0.6
    assert recall >= 0.5
    assert int(table.note.split()[0]) <= 20  # there are ten of them
