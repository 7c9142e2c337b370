"""Rows read back are what was written."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Ellipse, TrackWriter, read_track
from motes.cli import main
from motes.core.errors import ConfigError, FormatError, InputError
from motes.core.track import BOX, COLUMNS, Status, Track
from motes.formats import FilmFacts, registry
from motes.rows.schema import HINDSIGHT, FrameRow

forms = pytest.mark.parametrize("form", ["csv", "jsonl"])
HEAD = ",".join(COLUMNS)
ROW = "0,0.000000,1,,1,2,3,4,1,2,3,4,0,0.5,,tracking,0.1,100,"


def track(index: int) -> Track:
    ellipse = Ellipse(30.0 + index, 40.0, 10.0, 5.0, 0.25)
    return Track(index, index / 25, ellipse, np.eye(5), 0.5, Status.TRACKING, 0.1, 50.0)


def written(folder: Path, form: str) -> Path:
    path = folder / f"rows.{form}"
    with TrackWriter(path) as writer:
        writer.write(0, 0.0, None)
        for index in (1, 2):
            writer.write(index, index / 25, track(index))
    return path


@forms
def test_a_file_of_one_target(tmp_path: Path, form: str) -> None:
    rows = read_track(written(tmp_path, form))
    assert rows.dtype.names == COLUMNS
    assert rows.shape == (3,)
    assert rows["frame"].tolist() == [0, 1, 2]
    assert rows["frame"].dtype == np.int64
    assert rows["status"].tolist() == ["searching", "tracking", "tracking"]
    assert np.isnan(rows["x"][0])
    for row, index in zip(rows[1:], (1, 2), strict=True):
        expected = track(index).to_dict()
        assert row["label"] == ""
        assert np.isnan(row["occluded_by"])
        assert np.isnan(row["belief"])
        for name in set(COLUMNS) - {"label", "occluded_by", "belief"}:
            assert (
                row[name] == pytest.approx(expected[name], abs=1e-3)
                if name in BOX
                else expected[name]
            )


@forms
@pytest.mark.parametrize("turn", [0.0, 0.25])
def test_rows_that_are_read_and_written_again_are_the_same(
    tmp_path: Path, form: str, turn: float
) -> None:
    """Also the last digit of a box, which a rounded ellipse does not have, and absent targets.

    Of two objects one may be known in hindsight, and nothing tells whether the other is an outlier.
    """
    ellipse = Ellipse.from_box((10.1, 3.0, 7.001, 5.003))._replace(theta=turn)
    seen = replace(track(2), ellipse=ellipse, outlier=True)
    absent = replace(track(3), status=Status.ABSENT, ellipse=Ellipse(*[np.nan] * 5))
    names = "one", "known", "several", "mixed"
    one, known, several, mixed = (tmp_path / f"{name}.{form}" for name in names)
    for path, further in ((one, ()), (known, HINDSIGHT)):
        with TrackWriter(path, further=further) as writer:
            for index, each in enumerate((None, None, seen, absent)):
                if each is not None or not further:
                    writer.write(index, index / 25, each)
    with TrackWriter(several) as writer:
        van = replace(seen, identity=4, label="van, =old")
        objects = van, replace(track(2), identity=7, occluded_by=4)
        writer.add(FrameRow(2, 0.08, objects))
    with TrackWriter(mixed, further=HINDSIGHT) as writer:
        writer.add(FrameRow(2, 0.08, (van, replace(track(2), identity=7, smoothed=True))))
    assert read_track(mixed)["outlier"].tolist() == pytest.approx([np.nan, 0], nan_ok=True)
    for path in (one, known, several, mixed):
        again = tmp_path / f"again.{form}"
        registry.write(again, form, registry.read(path, form, FilmFacts()))
        assert again.read_bytes() == path.read_bytes()


@pytest.mark.slow
@forms
def test_a_data_frame(tmp_path: Path, form: str) -> None:
    path = written(tmp_path, form)
    frame = read_track(path, pandas=True)
    assert type(frame).__name__ == "DataFrame"
    assert tuple(frame.columns) == COLUMNS
    rows = read_track(path)
    for name in COLUMNS:
        np.testing.assert_array_equal(frame[name].to_numpy(), rows[name])


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("a.csv", "", "its columns are missing"),
        ("a.csv", "frame,hue\n0,1\n", "rows have no column hue: rename it, or rem"),
        ("a.csv", "frame,x\r0,1\r", "its lines end in carriage returns alone; save it anew"),
        ("a.csv", "frame;x\n0;1,5\n", "its columns are separated by ';'; write commas"),
        ("a.csv", "frame,x,x\n0,1,1\n", "its columns are frame, x, x"),
        ("a.csv", f"{HEAD}\n{ROW}\n{ROW[:12]}", "row 2 has 3 fields instead of 19"),
        (
            "a.csv",
            f"{HEAD}\n{ROW}\n{ROW.replace('0.5', 'half')}\n",
            "row 2: confidence: 'half' is not a number",
        ),
        ("a.csv", f"{HEAD}\n{ROW.replace('0,', '0.5,', 1)}\n", "row 1: frame: '0.5' is no whole"),
        ("a.csv", f"frame\n{1 << 70}\n", "too "),
        ("a.jsonl", '{"frame": 0}\n{"frame": 1, "x": 2}\n', "line 2 has other keys"),
        ("a.jsonl", '{"frame": 0, "status": 1}\n', "row 1: status: 1 is no text"),
        ("a.jsonl", '{"frame": 0}\n{"fra', "line 2: Input data was truncated"),
        ("a.jsonl", '[{"frame": 0}]\n', "line 1: Expected `object`"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, name: str, content: str, why: str) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(FormatError, match="is not a file of tracks") as error:
        read_track(path)
    assert why in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="No such file or directory"):
        read_track(tmp_path / "none.csv")
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="it is not text"):
        read_track(tmp_path / "bytes.csv")
    with pytest.raises(ConfigError, match=r"neither in \.csv nor in \.jsonl"):
        read_track(tmp_path / "rows.txt")


def test_parquet_is_read_as_the_rows_that_it_was_made_of(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    rows, path = written(tmp_path, "csv"), tmp_path / "rows.parquet"
    assert main(["convert", str(rows), str(path)]) == 0
    expected, found = read_track(rows), read_track(path)
    for name in expected.dtype.names or ():
        np.testing.assert_array_equal(found[name], expected[name])
    parquet.write_table(pyarrow.table({"frame": [0], "x": [[1.0]]}), tmp_path / "lists.parquet")
    (tmp_path / "cut.parquet").write_bytes(path.read_bytes()[:99])
    for wrong in ("lists", "cut", "missing"):
        with pytest.raises(InputError, match=rf"{wrong}\.parquet"):
            read_track(tmp_path / f"{wrong}.parquet")
