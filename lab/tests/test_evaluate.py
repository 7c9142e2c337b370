"""Protocols by hand, contestants of every kind, runs in which much goes wrong."""

import os
import pickle
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import arena
from arena import at_home
from clips import write_film
from in_process import InProcess
from motes import (
    PRESETS,
    Box,
    ConfigError,
    Ellipse,
    FormatError,
    Frame,
    Status,
    Track,
    configure,
    preset,
)
from motes_lab.adapters.opencv import PEERS, opencv
from motes_lab.adapters.registry import TrackerSpec, resolve, tracker_spec
from motes_lab.adapters.sot import Answer, TrackerAdapter
from motes_lab.datasets.sot import Sequence, load_dataset
from motes_lab.inputs import lines
from motes_lab.protocols.sot import TrackerPass, starts
from motes_lab.protocols.trace import TrackerOutput, load_trace, save_trace
from motes_lab.run_folder import Record, prepare, record
from motes_lab.runner import plan, run, unfinished


def sequence(boxes: list[list[float]], name: str = "film", source: str | Path = "none") -> Sequence:
    table = np.array(boxes, np.float64)
    ellipses = np.array([Ellipse.from_box(box) for box in table])
    return Sequence(name, source, table, ellipses)


ABSENT = [np.nan] * 4


class _Scripted(TrackerAdapter):
    """Says where the target is from a list, frame by frame; notes its starts."""

    def __init__(self, boxes: list[Box | None]) -> None:
        self.boxes = boxes
        self.begun: list[tuple[int, Box]] = []

    def init(self, frame: Frame, box: Box) -> Answer:
        self.begun.append((frame.index, box))
        return Answer(Ellipse.from_box(box), np.nan, False, 0.5)

    def update(self, frame: Frame) -> Answer:
        box = self.boxes[frame.index]
        ellipse = Ellipse.from_box(box) if box else None
        return Answer(ellipse, np.nan, box is None, 0.25)


def passed(truth: list[list[float]], boxes: list[Box | None]) -> tuple[TrackerOutput, Any]:
    film, contestant = sequence(truth), _Scripted(boxes)
    begin = starts("ope", film, 200, 100)[0]
    running = TrackerPass(lambda: contestant, begin)
    for index in range(len(truth)):
        running.feed(Frame(index, float(index), np.zeros((100, 200, 3), np.uint8)))
    return running.trace, contestant.begun


def test_one_pass_by_hand() -> None:
    truth = [ABSENT, *[[10.0, 10, 20, 20]] * 4]
    trace, begun = passed(truth, [None, None, Box(70, 9, 9, 9), None, Box(10, 10, 20, 20)])
    assert begun == [(1, Box(10, 10, 20, 20))]
    assert trace.lost.tolist() == [False, False, True, False]
    assert trace.ellipses[2].tolist() == trace.ellipses[1].tolist()  # its last
    assert trace.seconds.tolist() == [0.5, 0.25, 0.25, 0.25]


def test_traces_are_read_back_identically(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    trace = TrackerOutput(
        np.arange(7, 11),
        rng.uniform(1, 2, (4, 5)) * [[1e-8], [1], [1e8], [np.nan]],
        np.array([0.1, 1.0, np.nan, 1 / 3]),
        np.array([True, False, True, False]),
        np.array([1e-7, 2.0, 0.1 + 0.2, np.nan]),
        np.array([(1 / 3, -1e-9, 2.0)] * 3 + [(np.nan,) * 3]),
    )
    save_trace(tmp_path / "new" / "a.csv", trace)
    read = load_trace(tmp_path / "new" / "a.csv")
    for field in TrackerOutput.__slots__:
        np.testing.assert_array_equal(getattr(read, field), getattr(trace, field), strict=True)
    head, first = (tmp_path / "new" / "a.csv").read_text().splitlines()[:2]
    assert head == "frame,x,y,a,b,theta,confidence,lost,seconds,event,xx,xy,yy"
    assert first.split(",")[0] == "7"
    assert first.endswith(",0.1,1,1e-07,started,0.3333333333333333,-1e-09,2.0")


@pytest.mark.parametrize(
    "text",
    [
        *("", "frame,x\n1,2\n", None, "HEAD\n1,2,3\n", "HEAD\n", "HEAD\n1,a"),
        "HEAD\n7,1,2,3,4,0,,1,,tracked,,,\n",
        "HEAD\n7,1,2,3,4,0,,1,,started,,,\n8,1,2,3,4,0,,1,,started,,,\n",
    ],
)
def test_what_is_no_trace(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "a.csv"
    if text is not None:
        head = "frame,x,y,a,b,theta,confidence,lost,seconds,event,xx,xy,yy"
        path.write_text(text.replace("HEAD", head))
    with pytest.raises(FormatError, match=r"a\.csv"):
        load_trace(path)


@pytest.fixture
def home(tmp_path: Path) -> Iterator[Path]:
    """Return the current folder, with trackers of the user's own in it."""
    (tmp_path / "mine.py").write_text(arena.TRACKERS)
    with at_home(tmp_path, "mine"):
        yield tmp_path


def film(count: int = 2) -> list[tuple[Frame, Box]]:
    clip = islice(arena.still(), count)
    return [(frame, truths[0].ellipse.box) for frame, truths in clip]


EVERYONE = [
    "default",
    "nummiaro",
    "mean_shift",
    *PEERS,
    "mine:Still",
    "mine:Seeded",
    "changed.toml",
]


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERYONE)
def test_contestants_follow(name: str, home: Path) -> None:
    (home / "changed.toml").write_text('preset = "mean_shift"\ncolor.bins = [8, 8, 4]\n')
    clip = film(6)
    entered = tracker_spec(name)
    assert entered.name == name
    assert entered.configuration
    contestant = pickle.loads(pickle.dumps(entered)).begin(0)
    first = contestant.init(*clip[0])
    assert first.ellipse is not None
    assert tuple(first.ellipse.box) == pytest.approx(tuple(clip[0][1]))
    told = [contestant.update(frame) for frame, _ in clip[1:6]]
    for answer, (_, box) in zip([first, *told], clip, strict=False):
        assert answer.ellipse is not None
        assert np.hypot(*np.subtract(answer.ellipse, Ellipse.from_box(box))[:2]) < 8
        assert not answer.lost
        assert 0 < answer.seconds < 30
        assert (0 <= answer.confidence <= 1) == (name in PRESETS or name == "changed.toml")
        filtered = name in PRESETS and not name.startswith("mean_shift")
        assert np.isfinite(answer.covariance).all() == filtered
    # A second start is like the first, whatever has been since.
    clip = film(6)
    contestant.init(*clip[0])
    again = [contestant.update(frame) for frame, _ in clip[1:6]]
    assert [answer.ellipse for answer in again] == [answer.ellipse for answer in told]


def test_a_configuration_is_laid_over_its_preset(home: Path) -> None:
    Path("a.toml").write_text("particles = 42\n")
    Path("b.toml").write_text('preset = "nummiaro:adaptive"\nparticles = 42\n')
    a, b = tracker_spec("a.toml").configuration, tracker_spec("b.toml").configuration
    assert a == configure(preset("nummiaro"), {"particles": 42}).to_toml()
    assert b == configure(preset("nummiaro:adaptive"), {"particles": 42}).to_toml()


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("numiaro", "did you mean nummiaro?"),
        ("maggio:O-RO", "neither such a name here nor a module maggio; did you mean maggio"),
        ("motes:scene", "It follows many objects, and this dataset has one."),
        ("zzz", "known are default"),
        ("no.toml", "cannot be read: No such file"),
        ("bad.toml", "is not valid TOML"),
        ("key.toml", "did you mean 'particles'"),
        ("not_there:thing", "nor a module not_there; known are"),
        ("mine:nothing", "nothing of mine is a int, which is not callable"),
        ("needy:thing", "cannot be imported: No module named 'not_there'; install it"),
        ("leaving:thing", "cannot be imported: SystemExit"),
    ],
)
def test_trackers_that_are_none(name: str, error: str, home: Path) -> None:
    Path("bad.toml").write_text("a = = 3")
    Path("key.toml").write_text("particle = 3")
    Path("base.toml").write_text('preset = "numiaro"')
    Path("number.toml").write_text("preset = 3")
    Path("needy.py").write_text("import not_there")
    Path("broken.py").write_text("def")
    Path("leaving.py").write_text("raise SystemExit(1)")
    entries, problems = resolve([name, "nummiaro", "nummiaro"])
    assert [good.name for good in entries] == ["nummiaro"]
    assert [problem.where for problem in problems] == [f"tracker {name}"]
    assert error in problems[0].what
    assert lines(problems).endswith(problems[0].what)


def test_opencv_has_one_thread_of_blas(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """KCF takes five times as long where a second one has no core of its own."""
    (home / "cv2.py").write_text(
        "import os\nTHREADS = os.environ['OPENBLAS_NUM_THREADS']\n"
        "setNumThreads = TrackerCSRT_create = lambda *_: None\n"
    )
    monkeypatch.syspath_prepend(home)
    monkeypatch.setitem(sys.modules, "cv2", None)  # to be put back as it was
    for before in ("3", None):
        sys.modules.pop("cv2", None)
        monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
        if before is not None:
            monkeypatch.setenv("OPENBLAS_NUM_THREADS", before)
        assert opencv("cv2:csrt").THREADS == "1"
        assert os.environ.get("OPENBLAS_NUM_THREADS") == before


REGION = Ellipse(30.0, 20.0, 5.0, 4.0, 0.3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "ellipse", "confidence", "lost"),
    [
        (None, None, np.nan, True),
        ((1, 2, 3, 4), Ellipse.from_box((1, 2, 3, 4)), np.nan, False),
        (np.array([1, 2, 3, 4]), Ellipse.from_box((1, 2, 3, 4)), np.nan, False),
        (list(REGION), REGION, np.nan, False),
        ((True, (1, 2, 3, 4)), Ellipse.from_box((1, 2, 3, 4)), np.nan, False),
        ((False, [1, 2, 3, 4]), Ellipse.from_box((1, 2, 3, 4)), np.nan, True),
        ((False, None), None, np.nan, True),
        ((False, (0, 0, 0, 0)), None, np.nan, True),
        (Track(1, 0.1, REGION, np.eye(5), 0.7, Status.TRACKING, 0.1, 9), REGION, 0.7, False),
        (Track(1, 0.1, REGION, np.eye(5), 0.2, Status.SEARCHING, 0.1, 9), REGION, 0.2, True),
    ],
)
def test_what_callables_return(
    value: Any, ellipse: Ellipse | None, confidence: float, lost: bool, home: Path
) -> None:
    answer = _odd(value)
    assert answer.ellipse == ellipse
    assert answer.lost == lost
    np.testing.assert_equal(answer.confidence, confidence)


def told(region: Ellipse = REGION, confidence: float = 0.5) -> Track:
    return Track(1, 0.1, region, np.eye(5), confidence, Status.TRACKING, 0.1, 9)


NOTHING: list[Any] = [
    *(3, "box", (1, 2, 3), (True, None), (1, 2, 0, 4), (np.nan, 2, 3, 4), {}, (True, 1)),
    *((1e308, 2, 3, 4), (1, 2, 1e10, 4), (1, 2, 3, 1e-300)),
]
"""What is no region."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "error"),
    [
        *((value, "update of odd:Odd returned") for value in NOTHING),
        *((told(confidence=share), "confidence is from 0 to 1; got") for share in (1.1, -0.1)),
        (told(confidence=np.inf), "confidence is from 0 to 1; got inf"),
        (told(REGION._replace(x=np.nan)), "not finite"),
        (told(REGION._replace(a=1e200)), "not finite, or too large"),
        (told(REGION._replace(a=-1.0)), "no area"),
    ],
)
def test_what_callables_must_not_return(value: Any, error: str, home: Path) -> None:
    with pytest.raises(ConfigError, match=error):
        _odd(value)


ODD = """
class Odd:
    def init(self, image, box): pass
    def update(self, image): return self.value
"""


def _odd(value: Any) -> Answer:
    Path("odd.py").write_text(ODD)
    sys.modules.pop("odd", None)
    contestant = tracker_spec("odd:Odd").begin(0)
    first, second = film()
    contestant.init(*first)
    sys.modules["odd"].Odd.value = value
    answer: Answer = contestant.update(second[0])
    return answer


class _Recorder:
    """Notes what it is given, and answers what it shall."""

    answer: tuple[bool, tuple[float, ...]] = (True, (1.0, 2.0, 3.0, 4.0))

    def init(self, image: Any, box: Any) -> None:
        self.image, self.box = image, box

    def update(self, image: Any) -> tuple[bool, tuple[float, ...]]:
        return self.answer


@pytest.mark.parametrize(
    ("box", "whole"),
    [
        ((10.4, 20.6, 30.2, 40.0), (10, 21, 31, 40)),  # 10.4 … 40.6, 20.6 … 60.6
        ((-5.0, -3.0, 20.0, 10.0), (0, 0, 15, 7)),
        ((150.0, 110.0, 30.0, 40.0), (150, 110, 10, 10)),
        ((159.8, 119.9, 0.2, 0.1), (159, 119, 1, 1)),
        ((5.0, 5.0, 0.1, 0.1), (5, 5, 1, 1)),
    ],
)
def test_peers_get_whole_pixels_and_bgr(
    box: Any, whole: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = _Recorder()
    monkeypatch.setattr("motes_lab.adapters.sot.peer", lambda name, seed: recorder)
    contestant = tracker_spec("cv2:kcf").begin(0)
    frame = film()[0][0]
    assert contestant.init(frame, Box(*box)).ellipse == Ellipse.from_box(box)
    assert recorder.box == whole
    assert all(isinstance(number, int) for number in recorder.box)
    np.testing.assert_array_equal(recorder.image[:, :, ::-1], frame.pixels)
    assert contestant.update(frame).ellipse == Ellipse.from_box((1, 2, 3, 4))
    for recorder.answer in ((False, (1.0, 2.0, 3.0, 4.0)), (True, (1.0, 2.0, 0.0, 4.0))):
        answer = contestant.update(frame)
        assert answer.ellipse is None
        assert answer.lost


Dataset = tuple[list[TrackerSpec], list[Sequence]]


@pytest.fixture
def dataset(tmp_path: Path) -> Dataset:
    arena.write_sequence(tmp_path / "data" / "a", arena.still())
    sequences, problems = load_dataset(tmp_path / "data")
    assert not problems
    return resolve(["nummiaro", "mean_shift"])[0], sequences


def test_the_plan(dataset: Dataset, tmp_path: Path) -> None:
    entries, sequences = dataset
    gone = sequence([[1, 2, 3, 4]], "gone", tmp_path / "gone")
    jobs, problems = plan(entries, [gone, *sequences], ["ope", "pixel"], seeds=3)
    assert [problem.where for problem in problems] == ["sequence gone"]
    assert [job.name for job in jobs] == [
        "nummiaro on a, ope",
        "mean_shift on a, ope",
        "nummiaro on a, pixel",
        "mean_shift on a, pixel",
    ]
    assert [len(job.passes) for job in jobs] == [3, 1, 9, 3]
    assert {item.seed for item in jobs[0].passes} == {0, 1, 2}
    done = jobs[0].passes[1].path(tmp_path)
    done.parent.mkdir(parents=True)
    done.touch()
    left = unfinished(jobs[:2], tmp_path)
    assert [item.seed for item in left[0].passes] == [0, 2]
    jobs[1].passes[0].path(tmp_path).parent.mkdir(parents=True)
    jobs[1].passes[0].path(tmp_path).touch()
    assert [job.name for job in unfinished(jobs[:2], tmp_path)] == ["nummiaro on a, ope"]


def note(dataset: Dataset, path: str = "data", **changes: Any) -> Record:
    entries, sequences = dataset
    jobs, _ = plan(entries, sequences, ["ope"], 1)
    return msgspec.structs.replace(record(Path(path), jobs, entries, ["ope"], 1, 9.0), **changes)


def test_a_folder_is_not_taken_twice(dataset: Dataset, tmp_path: Path) -> None:
    out, now = tmp_path / "out", note(dataset)
    prepare(out, now, resume=True)  # nothing there yet is fine
    with pytest.raises(FormatError, match=r"holds an evaluation \(run\.json\).*--resume"):
        prepare(out, now)
    with pytest.raises(ConfigError, match="contradict"):
        prepare(out, now, resume=True, overwrite=True)
    prepare(out, now, resume=True)


def test_overwriting_removes_only_evaluations(dataset: Dataset, tmp_path: Path) -> None:
    out, now = tmp_path / "out", note(dataset)
    prepare(out, now)
    for name in ("tracks/a/b/ope-0.csv", "tracks/c/d/ope-0.csv", "results.csv", "summary.md"):
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).touch()
    for name in ("mine.txt", "tracks/c/mine.txt"):
        (out / name).touch()
    prepare(out, now, overwrite=True)
    left = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file())
    assert left == ["mine.txt", "run.json", "tracks/c/mine.txt"]
    assert not (out / "tracks" / "a").exists()


def test_resuming_something_else_is_refused(dataset: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    now = note(dataset)
    prepare(out, now)
    other = {
        "tracker mean_shift, which had": note(
            dataset, trackers={"mean_shift": "color.bins = [4, 4, 4]"}
        ),
        "sequence a, which had": note(dataset, sequences={"a": "0"}),
        "dataset, which was": note(dataset, path="elsewhere"),
        "version of motes, which was": note(dataset, motes="0.0.1"),
    }
    for error, changed in other.items():
        with pytest.raises(FormatError, match=f"cannot be resumed with this {error}.*--overwrite"):
            prepare(out, changed, resume=True)
    more = note(dataset, trackers={"new": "1"}, seeds=7, protocols=("ope", "pixel"))
    prepare(out, more, resume=True)
    prepare(out, now, resume=True)  # what was left out is still known
    with pytest.raises(FormatError, match="tracker new"):
        prepare(out, note(dataset, trackers={"new": "2"}), resume=True)
    for text in ("{", '{"motes": 3}'):
        (out / "run.json").write_text(text)
        with pytest.raises(FormatError, match=r"its run\.json cannot be read"):
            prepare(out, now, resume=True)
    (out / "run.json").unlink()
    (out / "results.csv").touch()
    with pytest.raises(FormatError, match=r"json cannot be read \(No such file or directory\); re"):
        prepare(out, now, resume=True)


FAILURES = {
    "mine:Dies on a": "It died.",
    "mine:Raises on a": "^At frame 7: ValueError: no more of this$",
    "mine:Exits on a": "At frame 7: SystemExit: 3",
    "mine:Interrupts on a": "At frame 7: KeyboardInterrupt$",
    "mine:Still on video-19": "has more frames than its truth, which has 19",
    "mine:Still on video-21": "has 20 frames, but its truth has 21",
}
"""What goes wrong in a run, and the reasons that are given; `Dies` ends its process."""


def test_failures_have_their_reasons(tmp_path: Path) -> None:
    arena.write_sequence(tmp_path / "data" / "a", arena.still())
    (tmp_path / "mine.py").write_text(arena.TRACKERS)
    write_film(tmp_path / "film.mkv", arena.still())
    with at_home(tmp_path, "mine"):
        entries, _ = resolve(f"mine:{name}" for name in ("Raises", "Exits", "Interrupts", "Seeded"))
        still, dies = resolve(["mine:Still"])[0], [replace(entries[-1], name="mine:Dies")]
        sequences, _ = load_dataset(tmp_path / "data")
        row = sequences[0].boxes[0].tolist()
        films = [
            sequence([row] * rows, f"video-{rows}", tmp_path / "film.mkv") for rows in (19, 20, 21)
        ]
        jobs = plan([*entries, *still], sequences, ["ope"], 3)[0]
        jobs += plan(still, films, ["ope"], 1)[0]
        jobs += plan(dies, sequences, ["ope"], 1)[0]
        pool = InProcess(["mine:Dies on a, ope"] * 9)
        steps = [*run(pool, jobs, tmp_path / "out", 600)]
    assert sorted(step.job.name for step in steps if step.errors is None) == sorted(pool.done)
    ended = {step.job.name: step.errors for step in steps if step.errors is not None}
    assert sorted(ended) == sorted(job.name for job in jobs)
    failed = {name.removesuffix(", ope"): errors for name, errors in ended.items() if errors}
    assert failed.keys() == FAILURES.keys()
    for name, errors in failed.items():
        ((item, text),) = errors.items()
        assert re.search(FAILURES[name], text), text
        assert not item.path(tmp_path / "out").exists() or name == "mine:Dies on a"


@pytest.mark.slow
def test_a_full_disk(dataset: Dataset, tmp_path: Path) -> None:
    jobs, _ = plan(dataset[0], dataset[1], ["ope"], 2)
    first, second = (item.path(tmp_path) for item in jobs[0].passes)
    first.parent.mkdir(parents=True)
    second.symlink_to("/dev/full")
    with pytest.raises(FormatError, match=r"ope-1\.csv cannot be written: No space.*make room"):
        [*run(InProcess(), jobs, tmp_path, 60)]
    assert len(load_trace(first).frames) == arena.FRAMES
    assert sorted(first.parent.iterdir()) == [first, second]
