"""Files that are whole or not there, and no other file touched by making them."""

import os
from pathlib import Path

import pytest

from disks import fill
from motes.core.files import PartialFile, leftovers, open_rows, same_file, write_whole


def test_a_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    for data in (b"one", b"another"):
        write_whole(path, data)
        assert path.read_bytes() == data
    assert os.listdir(tmp_path) == ["a.json"]


@pytest.mark.parametrize("interrupt", [OSError, KeyboardInterrupt])
def test_what_fails_leaves_the_old_file_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interrupt: type[BaseException]
) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(b"old")

    def fail(*_: object) -> None:
        raise interrupt

    monkeypatch.setattr(PartialFile, "_put", fail)
    with pytest.raises(interrupt):
        write_whole(path, b"new")
    assert os.listdir(tmp_path) == ["a.json"]
    assert path.read_bytes() == b"old"


def test_files_and_links_of_others_are_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever name the partial file would have, what is there is neither replaced nor followed."""
    monkeypatch.setattr("secrets.token_hex", lambda _: "0" * 16)
    (tmp_path / "precious").write_text("precious")
    taken = tmp_path / f"a.json.partial-{'0' * 16}"
    for make in (taken.symlink_to, taken.hardlink_to):
        make(tmp_path / "precious")
        with pytest.raises(FileExistsError):
            write_whole(tmp_path / "a.json", b"new")
        assert (tmp_path / "precious").read_text() == taken.read_text() == "precious"
        taken.unlink()


def test_what_a_link_leads_to_is_written(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    for name in ("there", "missing"):
        link = tmp_path / name
        link.symlink_to(tmp_path / "far" / name)
        if name == "there":
            link.write_text("old")
        write_whole(link, b"new")
        assert link.is_symlink()
        assert (tmp_path / "far" / name).read_bytes() == b"new"
    link = tmp_path / "rows"
    link.symlink_to(tmp_path / "far" / "rows")
    open_rows(link, overwrite=False).close()
    assert (tmp_path / "far" / "rows").exists()


def test_pipes_and_devices_are_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_whole(tmp_path / "pipe", b"news")
    assert os.read(reader, 9) == b"news"
    os.close(reader)
    assert not (tmp_path / "pipe").is_file()
    with pytest.raises(OSError, match="No space"):
        write_whole("/dev/full", b"news")
    with open_rows("/dev/full", overwrite=False) as rows, pytest.raises(OSError, match="No space"):
        rows.write(b"news")


def test_rows_never_empty_a_file_that_appeared(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("precious")
    with pytest.raises(FileExistsError):
        open_rows(tmp_path / "r.csv", overwrite=False)
    assert (tmp_path / "r.csv").read_text() == "precious"
    open_rows(tmp_path / "r.csv", overwrite=True).close()
    assert (tmp_path / "r.csv").read_text() == ""


def test_leftovers_are_those_of_one_target(tmp_path: Path) -> None:
    target = tmp_path / "o[1].mp4"
    left = [PartialFile(target, ".mp4"), PartialFile(target)]
    PartialFile(tmp_path / "o1.mp4").close()
    for name in ("o[1].mp4.partial.mkv", "o[1].mp4.partial-mine.mp4"):
        (tmp_path / name).touch()
    assert leftovers(target) == sorted(each.path for each in left)
    (tmp_path / "link.mp4").symlink_to(target)
    assert leftovers(tmp_path / "link.mp4") == leftovers(target)
    for each in left:
        each.drop()
    assert leftovers(target) == []


def test_appended_at_once_and_changed_in_the_end(tmp_path: Path) -> None:
    partial = PartialFile(tmp_path / "o")
    assert partial.write(b"head body ") == 10
    partial.seek(0)
    partial.write(b"HEAD")
    partial.seek(-1, os.SEEK_END)
    partial.write(b"_tail")  # half of it over what is there
    assert partial.tell() == 14
    assert partial.path.read_bytes() == b"head body tail"
    partial.finish(overwrite=False)
    assert (tmp_path / "o").read_bytes() == b"HEAD body_tail"


def test_what_cannot_be_appended_leaves_no_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    partial = PartialFile(tmp_path / "o")
    partial.write(b"all of this")
    with monkeypatch.context() as patch:
        fill(patch, "o")
        with pytest.raises(OSError, match="No space"):
            partial.write(b"half of that")
    assert partial.path.read_bytes() == b"all of this"
    partial.write(b", and this")
    partial.finish(overwrite=False)
    assert (tmp_path / "o").read_bytes() == b"all of this, and this"


def test_the_same_file_by_any_name(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.touch()
    (tmp_path / "hard").hardlink_to(path)
    (tmp_path / "soft").symlink_to(path)
    for other in ("a", "hard", "soft", "../" + tmp_path.name + "/a"):
        assert same_file(path, tmp_path / other)
    (tmp_path / "b").touch()
    assert not same_file(path, tmp_path / "b")
    assert same_file(tmp_path / "none", tmp_path / "." / "none")
    assert not same_file(tmp_path / "none", tmp_path / "a")
