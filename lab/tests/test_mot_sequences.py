"""Rows of the MOTChallenge, and datasets in its layout, good and bad."""

from pathlib import Path

import pytest

from clips import write_film
from evaluations import pictures
from motes import SourceError, open_source
from motes.synthetic import still
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.datasets.mot_rows import Kind, MotRows, read_rows

INI = "[Sequence]\nname=other\nimDir=img1\nframeRate=12.5\nseqLength=4\nimExt=.png\n"
TRUTH = "1,1,5,6,20,30,1,1,1\n2,1,6,6,20,30,1,1,0.5\n\n1,2,50,6,20,30,0,1,1\n"
DETECTIONS = "2,-1,6,6,20,30,0.7\n2,-1,40,6,20,30,0.2\n"


def write(folder: Path, name: str = "film", text: str = TRUTH, ini: str = INI) -> Path:
    """Make a sequence of four pictures."""
    pictures(folder / name / "img1", 4)
    for path, content in (("seqinfo.ini", ini), ("gt/gt.txt", text), ("det/det.txt", DETECTIONS)):
        (folder / name / path).parent.mkdir(exist_ok=True)
        (folder / name / path).write_text(content)
    return folder / name


def read(tmp_path: Path, text: str, kind: Kind = "truth") -> MotRows:
    (tmp_path / "gt").mkdir(exist_ok=True)
    (tmp_path / "gt" / "gt.txt").write_text(text)
    return read_rows(tmp_path / "gt" / "gt.txt", 9, kind)


def test_rows(tmp_path: Path) -> None:
    text = "2, 1, 5.5 ,6,20,30,1,7,0.3\n\n 1;-3;1;2;3;4;0.5;-1;1\n1 4 1 2 3 4 1 -1\t1\n"
    found = read(tmp_path, text)
    assert found.frames.tolist() == [1, 1, 2]  # and within a frame, as in the file
    assert found.ids.tolist() == [-3, 4, 1]
    assert found.boxes.tolist() == [[1, 2, 3, 4], [1, 2, 3, 4], [5.5, 6, 20, 30]]
    assert found.scores.tolist() == [0.5, 1, 1]
    assert found.classes.tolist() == [-1, -1, 7]
    assert found.listed(1) == [(1, (4.5, 5, 20, 30), 1)]
    assert found.listed(4) == []
    assert found.at(1) == slice(0, 2)
    many = read(tmp_path, "".join(f"{2 - i % 2},{i},1,2,3,4,1\n" for i in range(60)))
    assert many.ids.tolist() == [*range(1, 60, 2), *range(0, 60, 2)]


@pytest.mark.parametrize("more", ["3.5", "7,0.5,-1", "3.5,-2.5,0"])
def test_classes_are_where_the_truth_has_them(tmp_path: Path, more: str) -> None:
    """Not among coordinates in the world, and not in results."""
    line = "1,1,5,6,20,30,1,"
    assert read(tmp_path, line + "7\n").classes.tolist() == [7]
    assert read(tmp_path, line + "7,0.5\n").classes.tolist() == [7]
    assert read(tmp_path, f"{line}{more}\n", "results").classes.tolist() == [-1]
    if more.count(",") > 1:
        assert read(tmp_path, f"{line}{more}\n").classes.tolist() == [-1]


def loaded(path: Path) -> MotSequence:
    crowds, problems = load_mot_dataset(path)
    assert problems == []
    return crowds[0]


def test_a_sequence(tmp_path: Path) -> None:
    crowd = loaded(write(tmp_path))
    assert (crowd.name, crowd.frames, crowd.rate) == ("film", 4, 12.5)
    assert crowd.truth.ids.tolist() == [1, 2, 1]
    assert crowd.detections is not None
    assert crowd.detections.scores.tolist() == [0.7, 0.2]
    with open_source(crowd.source) as film:
        assert len(list(film)) == 4


def test_a_folder_without_sequences_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=r"There is no file or folder .*nowhere; check the name"):
        load_mot_dataset(tmp_path / "nowhere")
    with pytest.raises(SourceError, match="There is no sequence of many objects"):
        load_mot_dataset(tmp_path)


def test_a_dataset(tmp_path: Path) -> None:
    for name in ("b", "a", "c"):
        write(tmp_path, name)
    pictures(tmp_path / "others", 2)
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "c" / "gt" / "gt.txt").write_text("1,1,2\n")
    crowds, problems = load_mot_dataset(tmp_path)
    assert [crowd.name for crowd in crowds] == ["a", "b"]
    assert [(problem.where, problem.what) for problem in problems] == [
        (
            "sequence c",
            "gt/gt.txt, line 1: 3 numbers, but a line has 7 to 10: frame, id, x, y, width, "
            "height, score, and up to three more",
        )
    ]


def test_other_places(tmp_path: Path) -> None:
    """Pictures in another folder, a video instead of pictures, no detections."""
    folder = write(tmp_path, ini=INI.replace("imDir=img1\n", "imDir=frames\n"))
    (folder / "img1").rename(folder / "frames")
    (folder / "det" / "det.txt").unlink()
    assert loaded(folder).source == folder / "frames"
    assert loaded(folder).detections is None
    for path in (folder / "frames").iterdir():
        path.unlink()
    (folder / "frames").rmdir()
    write_film(folder / "film.mp4", still((160, 120), target=(30, 40), frames=4))
    assert loaded(folder).source == folder / "film.mp4"


def test_a_digest_tells_truth_and_detections_apart(tmp_path: Path) -> None:
    folder = write(tmp_path)
    before = loaded(folder).digest
    assert loaded(folder).digest == before
    (folder / "det" / "det.txt").write_text(DETECTIONS.replace("0.7", "0.8"))
    other = loaded(folder).digest
    (folder / "gt" / "gt.txt").write_text(TRUTH.replace("2,1,6", "2,1,7"))
    assert len({before, other, loaded(folder).digest}) == 3


@pytest.mark.parametrize(
    ("path", "text", "error"),
    [
        ("seqinfo.ini", None, "it has no seqinfo.ini; add one with seqLength and frameRate"),
        ("seqinfo.ini", "seqLength=4\n", "seqinfo.ini is not valid: File contains no section"),
        ("seqinfo.ini", "[Sequence]\nseqLength=4\n", "seqinfo.ini does not have 'frameRate'"),
        ("seqinfo.ini", INI.replace("=4", "=0"), "seqinfo.ini has 0 frames at 12.5 frames per"),
        ("seqinfo.ini", INI.replace("=4", "=5"), "seqinfo.ini has 5 frames, but img1/ has 4"),
        ("seqinfo.ini", INI.replace("img1", "no"), "it has no folder no/, and no videos instead"),
        ("gt/gt.txt", None, "it has no truth; add a file gt/gt.txt"),
        ("gt/gt.txt", "1,2,50,6,20,30,1,3,1\n", "gt/gt.txt has no row that counts"),
        ("det/det.txt", "1,-1\n", "det/det.txt, line 1: 2 numbers"),
        ("img1/0002.png", None, "the frame 0002.png is missing after 0001.png"),
    ],
)
def test_bad_sequences(tmp_path: Path, path: str, text: str | None, error: str) -> None:
    folder = write(tmp_path)
    if text is None:
        (folder / path).unlink()
    else:
        (folder / path).write_text(text)
    crowds, problems = load_mot_dataset(folder)
    assert crowds == []
    assert problems[0].what.startswith(error)
    assert "\n" not in problems[0].what
