"""Keyframes: their file, their forms, and what contradicts them."""

import csv
from pathlib import Path

import pytest

from motes import ConfigError, Ellipse, FormatError
from motes.correction.keyframes import check_keyframes, keyframes, marks_of, named, read_keyframes


def test_a_file_of_keyframes(tmp_path: Path) -> None:
    path = tmp_path / "keys.csv"
    path.write_text(
        "frame,x,y,a,b,theta\n\n# a remark\n90,310.5,214,21,33,0.12\n0,320,230,20,30,0\n"
        "130,absent,,,,\n135:137,absent\n"
    )
    found = read_keyframes(path)
    assert list(found) == [""]
    assert list(found[""].items()) == [
        (0, Ellipse(320, 230, 20, 30, 0)),
        (90, Ellipse(310.5, 214, 21, 33, 0.12)),
        *((frame, None) for frame in (130, 135, 136, 137)),
    ]


def test_rows_may_name_their_film(tmp_path: Path) -> None:
    path = tmp_path / "keys.csv"
    path.write_text("Film,Frame,Region\na.mp4,0,3,2,40,60\nb.mp4,5,1,1,20,20\na.mp4,9,absent\n")
    found = read_keyframes(path)
    assert {film: list(marks) for film, marks in found.items()} == {"a.mp4": [0, 9], "b.mp4": [5]}


def test_names_of_films_are_quoted_as_spreadsheets_do(tmp_path: Path) -> None:
    path = tmp_path / "keys.csv"
    names = ["cup, red.mp4", 'say "hi".mp4', "#1.mp4", "it's.mp4"]
    with path.open("w", newline="") as file:
        rows = csv.writer(file, quoting=csv.QUOTE_ALL)
        rows.writerow(["film", "frame", "x", "y", "width", "height"])
        rows.writerows([name, 0, 3, 2, 40, 60] for name in names)
    assert list(read_keyframes(path)) == names


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("7,1,2,3", "row 2: A region has 4 numbers"),
        ("7", "row 2: it has no region"),
        ("7;1,5;2;3;4", "row 2: it has no region; give x,y,width,height, with commas and points"),
        ("-1,1,2,30,40", "row 2: '-1' is no frame"),
        ("7,here", "row 2: 'here' is no region of frame 7"),
        ("7:9,1,2,3,4", "row 2: The frames 7:9 have one region"),
        ("9:7,absent", "row 2: The frames 9:7 are no range"),
        ("7,1,2,30,40,0.5", "row 2: it has 5 numbers, and a region of this file has 4"),
        ("7,absent,4", "row 2: 'absent,4' is no region"),
        ("0,absent", "frame 0 contradict each other: 1,2,30,40 and absent; keep one"),
    ],
)
def test_other_rows_are_refused(tmp_path: Path, row: str, message: str) -> None:
    path = tmp_path / "keys.csv"
    path.write_text(f"0,1,2,30,40\n{row}\n")
    with pytest.raises(FormatError) as raised:
        read_keyframes(path)
    assert message in str(raised.value)


@pytest.mark.parametrize("text", ["90,310,214,21,33", "frame,x,y,a,b,theta\n90,310,214,21,33\n"])
def test_an_ellipse_that_lost_its_angle_is_no_box(text: str, tmp_path: Path) -> None:
    path = tmp_path / "keys.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match=r"a region of this file has 5|last line has no end"):
        read_keyframes(path)


def test_a_file_without_keyframes(tmp_path: Path) -> None:
    path = tmp_path / "keys.csv"
    with pytest.raises(FormatError, match="cannot be read"):
        read_keyframes(path)
    path.write_text("frame,x,y,width,height\n")
    with pytest.raises(FormatError, match="has no keyframe"):
        read_keyframes(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="it is not text"):
        read_keyframes(path)


def test_the_same_mark_twice_is_one() -> None:
    marks = [*marks_of("4", "1,2,30,40"), *marks_of("4", "1,2,30,40"), *marks_of("2", "absent")]
    assert list(keyframes(marks)) == [2, 4]
    assert named(keyframes(marks)[4]) == "1,2,30,40"
    with pytest.raises(ConfigError, match="negative"):
        keyframes([(-1, None)])


def test_keyframes_belong_to_the_film() -> None:
    frames = range(10, 50)
    inside = keyframes([(10, (5, 5, 20, 20)), (49, None)])
    check_keyframes(inside, "a.mp4", frames, 100, 80)
    with pytest.raises(ConfigError, match=r"keyframe 50 is outside of a.mp4, .* 10 to 49"):
        check_keyframes({**inside, 50: None}, "a.mp4", frames, 100, 80)
    absent = keyframes(marks_of("49:99", "absent"))
    with pytest.raises(ConfigError, match="keyframe 99 is outside of"):  # as it was given, not 50
        check_keyframes({**inside, **absent}, "a.mp4", frames, 100, 80)
    with pytest.raises(ConfigError, match=r"Keyframe 10 of a.mp4: .* center outside"):
        check_keyframes(inside, "a.mp4", frames, 12, 12)
    with pytest.raises(ConfigError, match="No keyframe marks the target"):
        check_keyframes({12: None}, "a.mp4", frames, 100, 80)
