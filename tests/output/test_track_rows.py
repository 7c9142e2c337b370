"""Rows: what is in them, what happens to what is there already, and how they are resumed."""

import csv
import io
import json
import math
import resource
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes import ConfigError, Ellipse, FormatError
from motes.core.files import check_writable
from motes.core.track import BOX, COLUMNS, ELLIPSE, Status, Track
from motes.rows.schema import Form, Header
from motes.rows.writer import JournalWriter, Lines, TrackWriter

DIGITS = {"time": 6, "effective_sample_size": 2} | dict.fromkeys((*BOX, *ELLIPSE[:-1]), 3)


def made(index: int = 0, value: float = 1.0, status: Status = Status.TRACKING) -> Track:
    """Return a track whose numbers are all derived from one."""
    ellipse = Ellipse(value, 2 * value, 3.25, 4.5, value / 3)
    return Track(index, index / 25, ellipse, np.eye(5), 0.5, status, value / 7, 99.999)


Rows = list[tuple[int, float, Track | None]]


def rows(count: int) -> Rows:
    """Return rows whose first two have no track."""
    return [(n, n / 25, made(n, 1.1 * n) if n > 1 else None) for n in range(count)]


def write(
    path: Path, content: Rows, *, overwrite: bool = False, resume: bool = False
) -> TrackWriter:
    """Write rows and return the writer."""
    with TrackWriter(path, overwrite=overwrite, resume=resume) as writer:
        for row in content:
            writer.write(*row)
    return writer


def test_rows_say_what_the_tracks_say_in_both_forms(tmp_path: Path) -> None:
    write(tmp_path / "r.csv", rows(4))
    write(tmp_path / "r.jsonl", rows(4))
    table = list(csv.DictReader(io.StringIO((tmp_path / "r.csv").read_text())))
    objects = [json.loads(line) for line in (tmp_path / "r.jsonl").read_text().splitlines()]
    assert tuple(table[0]) == tuple(objects[0]) == COLUMNS
    for (index, time, track), texts, values in zip(rows(4), table, objects, strict=True):
        expected: dict[str, object] = dict.fromkeys(COLUMNS)
        expected |= {"frame": index, "time": time, "id": 1, "status": "searching"}
        if track is not None:
            expected |= track.ellipse._asdict() | dict(zip(BOX, track.box, strict=True))
            for name in ("confidence", "distance", "effective_sample_size", "status"):
                expected[name] = getattr(track, name)
        for name, value in expected.items():
            if isinstance(value, float):
                assert values[name] == round(value, DIGITS.get(name, 5))
                assert float(texts[name]) == values[name]
            else:
                assert values[name] == value
                assert texts[name] == ("" if value is None else str(value))


@given(st.lists(st.floats(), min_size=8, max_size=8), st.sampled_from(Status))
def test_what_is_not_finite_is_left_out(values: list[float], status: Status) -> None:
    x, y, a, b, theta, confidence, distance, size = values
    track = Track(0, 0.0, Ellipse(x, y, a, b, theta), np.eye(5), confidence, status, distance, size)
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder, "r.csv"), [(0, 0.0, track)])
        write(Path(folder, "r.jsonl"), [(0, 0.0, track)])
        texts = next(csv.DictReader(io.StringIO(Path(folder, "r.csv").read_text())))
        read = json.loads(Path(folder, "r.jsonl").read_text())
    for name in set(COLUMNS) - {"frame", "id", "status"}:
        assert read[name] is None or math.isfinite(read[name])
        assert (texts[name] == "") == (read[name] is None)
    assert (read["x"] is None) == (not math.isfinite(x))


def test_what_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="is a folder; give the name of a file"):
        check_writable(tmp_path, overwrite=True)
    with pytest.raises(FormatError, match=r"There is no folder .* make it first"):
        check_writable(tmp_path / "none" / "r.csv")


def test_a_place_without_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)  # root may write anywhere
    with pytest.raises(FormatError, match="no permission; choose another place"):
        check_writable(tmp_path / "r.csv")


def test_two_runs_do_not_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    late = TrackWriter(path)
    write(path, rows(4))
    before = path.read_bytes()
    for second in (
        lambda: late.write(*rows(1)[0]),
        lambda: JournalWriter(path, Header("film", 9, 9, "x")),
    ):
        with pytest.raises(FormatError, match="another run writes it"):
            second()
    assert path.read_bytes() == before


@pytest.mark.parametrize("another", [True, False])
def test_a_file_that_is_deleted_meanwhile_is_an_error(tmp_path: Path, another: bool) -> None:
    """The run would go on and say that it wrote the file. A file that was moved is still there."""
    path, kept = tmp_path / "r.csv", tmp_path / "kept.csv"
    with TrackWriter(path) as writer, Lines(str(tmp_path / "lines.csv"), False) as lines:
        writer.write(*rows(1)[0])
        lines.put(["1"])
        path.rename(kept)
        writer.write(*rows(2)[1])
        path.with_name("lines.csv").unlink()
        kept.unlink()
        if another:
            path.touch()
        with pytest.raises(FormatError, match=r"r.csv was deleted or replaced"):
            writer.write(*rows(3)[2])
        with pytest.raises(FormatError, match=r"lines.csv was deleted"):
            lines.put(["2"])


def test_rows_of_two_runs_that_overwrite_are_not_mixed(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    with TrackWriter(path, overwrite=True) as first, TrackWriter(path, overwrite=True) as second:
        first.write(*rows(1)[0])
        second.write(*rows(1)[0])
        with pytest.raises(FormatError, match=r"r.csv was deleted or replaced"):
            first.write(*rows(2)[1])
        second.write(*rows(2)[1])
    assert [row["frame"] for row in csv.DictReader(path.read_text().splitlines())] == ["0", "1"]


def test_a_full_disk_is_one_clear_error() -> None:
    with (
        pytest.raises(FormatError, match="No space left on device; make room"),
        TrackWriter("/dev/full", "csv") as writer,
    ):
        writer.write(0, 0.0, None)


@pytest.mark.parametrize("form", ["csv", "jsonl"])
@given(st.data())
def test_a_cut_file_is_resumed_to_the_same_bytes(form: Form, data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"r.{form}")
        whole = write(path, rows(6))
        text = path.read_bytes()
        assert (whole.rows, whole.resumed) == (6, 0)
        cut = data.draw(st.integers(0, len(text)))
        path.write_bytes(text[:cut])
        resumed = write(path, rows(6), resume=True)
        assert path.read_bytes() == text
        header = form == "csv" and cut > 0
        assert (resumed.rows, resumed.resumed) == (6, max(0, text[:cut].count(b"\n") - header))


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda text: text.replace("2.200", "2.300"), "its line 4 differs"),
        (lambda text: text.replace("frame,", "number,"), "its line 1 differs"),
        (lambda text: "precious", "its line 1 differs"),
        (lambda text: text[: text.index("2.200")] + "9", "its line 4 differs"),
        (lambda text: text + "5,0.2,1\n", "more than the 6 lines"),
    ],
)
def test_other_rows_cannot_be_resumed_and_stay(tmp_path: Path, change, where: str) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "r.csv"
    write(path, rows(5))
    path.write_text(change(path.read_text()))
    before = path.read_bytes()
    with pytest.raises(FormatError, match=where) as error:
        write(path, rows(5), resume=True)
    assert "not the same" in str(error.value)
    assert "write to another file" in str(error.value)
    assert path.read_bytes() == before


def test_a_row_that_does_not_fit_leaves_whole_rows(tmp_path: Path) -> None:
    write(tmp_path / "whole.csv", rows(50))
    text = (tmp_path / "whole.csv").read_bytes()
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(text) // 2, limit[1]))
    try:
        with pytest.raises(FormatError, match=r"r\.csv cannot be written: .*lines so far are kept"):
            write(tmp_path / "r.csv", rows(50))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    kept = (tmp_path / "r.csv").read_bytes()
    assert 1000 < len(kept) <= len(text) // 2
    assert text.startswith(kept)
    assert kept.endswith(b"\n")
    write(tmp_path / "r.csv", rows(50), resume=True)
    assert (tmp_path / "r.csv").read_bytes() == text


def test_what_is_no_file_cannot_be_resumed() -> None:
    with pytest.raises(ConfigError, match="Standard output cannot be resumed"):
        TrackWriter("-", resume=True)
    with pytest.raises(ConfigError, match="not an ordinary file"):
        TrackWriter("/dev/null", "csv", resume=True)
