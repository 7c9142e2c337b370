"""Writing: what comes out, and what is left when things go wrong."""

import errno
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from clips import picture
from disks import fill
from motes import ConfigError, FormatError, open_source
from motes.core.files import PartialFile, leftovers
from motes.video.writer import ENDINGS, VideoWriter
from scripts import uncounted

KINDS = [".mkv", ".mp4"]
"""One ending of each container."""


def run(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    """Run a program that may be killed, or have no room for files; its lines are not counted."""
    head = """
import os, resource, signal
from clips import noise, picture
from motes.core.errors import FormatError
from motes.video.writer import VideoWriter
"""
    return subprocess.run(
        [sys.executable, "-c", head + textwrap.dedent(script)],
        cwd=folder,
        env={
            **uncounted(),
            "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1]), *sys.path]),
        },
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_written_can_be_read(tmp_path: Path, ending: str) -> None:
    width, height = 63, 47
    path = tmp_path / f"out{ending}"
    with VideoWriter(path, 30) as writer:
        for index in range(40):
            writer.write(picture(index, width, height))
            assert not path.exists()
    assert os.listdir(tmp_path) == [path.name]
    with open_source(path) as source:
        assert (source.width, source.height) == (width + width % 2, height + height % 2)
        assert source.fps == pytest.approx(30)
        frames = list(source)
    assert len(frames) == 40
    assert source.report.problems is None
    for frame in frames:
        assert frame.time == pytest.approx(frame.index / 30, abs=0.0006)
        expected = np.pad(
            picture(frame.index, width, height),
            ((0, height % 2), (0, width % 2), (0, 0)),
            mode="edge",
        )
        assert np.abs(frame.pixels - expected.astype(int)).mean() < 6


def test_colors_survive(tmp_path: Path) -> None:
    colors = [(200, 30, 30), (30, 200, 30), (30, 30, 200), (128, 128, 128)]
    pixels = np.repeat(np.array([colors], np.uint8), 16, axis=1).repeat(32, axis=0)
    with VideoWriter(tmp_path / "colors.mp4", 25) as writer:
        writer.write(pixels)
    with open_source(tmp_path / "colors.mp4") as source:
        seen = next(source).pixels[16, 8::16].astype(int)
    assert np.abs(seen - colors).max() <= 6


def test_times_that_do_not_increase_still_keep_every_picture(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "out.mp4", 25) as writer:
        for index in range(5):
            writer.write(picture(index), 0.1)
    with open_source(tmp_path / "out.mp4") as source:
        assert len(list(source)) == 5


@pytest.mark.parametrize("fps", [np.float32(12.5), 1 / 3600])
def test_a_rate_of_numpy_and_a_picture_an_hour(fps: float, tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "out.mkv", fps) as writer:
        for level in range(3):
            writer.write(np.full((16, 16, 3), level, np.uint8))
    with open_source(tmp_path / "out.mkv") as source:
        assert source.fps == pytest.approx(fps, rel=1e-3)
        assert source.frame_count == 3


def test_what_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    existing = tmp_path / "existing.mp4"
    existing.write_text("precious")
    (tmp_path / "folder.mp4").mkdir()
    for path, kind, words in [
        (existing, FormatError, r"\(overwrite=True"),
        (tmp_path / "folder.mp4", FormatError, "is a folder"),
        (tmp_path / "missing" / "out.mp4", FormatError, "make it first"),
        (tmp_path / "out.avi", ConfigError, r"\.m4v, \.mkv, \.mov, \.mp4"),
        (tmp_path / "out", ConfigError, "does not end like a video"),
    ]:
        with pytest.raises(kind, match=words) as caught:
            VideoWriter(path, 25)
        assert "\n" not in str(caught.value)
    for fps in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ConfigError, match="frames per second"):
            VideoWriter(tmp_path / "out.mp4", fps)
    assert existing.read_text() == "precious"


def test_overwriting_happens_only_in_the_end(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    path.write_text("old")
    with VideoWriter(path, 25, overwrite=True) as writer:
        writer.write(picture(0))
        assert path.read_text() == "old"
    with open_source(path) as source:
        assert len(list(source)) == 1


def test_without_pictures_there_is_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "out.mp4", 25):
        pass
    assert os.listdir(tmp_path) == []


def test_a_picture_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "out.mp4", 25) as writer:
        writer.write(picture(0))
        for pixels in (picture(0)[:, :, 0], picture(0).astype(float), picture(0, 66, 48)):
            with pytest.raises(FormatError):
                writer.write(pixels)


def test_after_an_interrupt_the_partial_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    with pytest.raises(KeyboardInterrupt), VideoWriter(path, 25) as writer:  # noqa: PT012
        for index in range(30):
            writer.write(picture(index))
        raise KeyboardInterrupt
    with open_source(left(tmp_path)) as source:
        assert len(list(source)) == 30
        assert source.report.problems is None


def left(folder: Path) -> Path:
    """Return the one file in a folder, which is a partial one."""
    (path,) = folder.iterdir()
    target = path.name.partition(".partial-")[0]
    assert leftovers(folder / target) == [path]
    assert path.suffix == Path(target).suffix
    return path


@pytest.mark.slow
@pytest.mark.parametrize("ending", KINDS)
def test_any_number_of_pictures_makes_a_film(tmp_path: Path, ending: str) -> None:
    """Seven once made none."""
    rates = (7.5, 24000 / 1001, 25, 60)
    for count in (1, 2, 3, 6, 7, 8, 9, 25, 40):
        fps = rates[count % len(rates)]
        path = tmp_path / f"{count}{ending}"
        with VideoWriter(path, fps) as writer:
            for index in range(count):
                writer.write(picture(index, 32 + count, 24))
        with open_source(path) as source:
            times = [frame.time for frame in source]
        assert source.report.problems is None
        assert times == pytest.approx([index / fps for index in range(count)], abs=0.0011)


@pytest.mark.slow
@pytest.mark.parametrize("ending", KINDS)
def test_a_killed_program_leaves_all_but_the_last_picture(tmp_path: Path, ending: str) -> None:
    result = run(
        tmp_path,
        f"""
        writer = VideoWriter("out{ending}", 25)
        for index in range(50):
            writer.write(picture(index))
        os.kill(os.getpid(), signal.SIGKILL)
        """,
    )
    assert result.returncode == -signal.SIGKILL, result.stderr
    with open_source(left(tmp_path)) as source:
        times = [frame.time for frame in source]
    assert source.report.problems is None
    assert len(times) >= 48
    assert times == pytest.approx([index / 25 for index in range(len(times))])


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_film_can_be_read_at_any_moment_of_its_end(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever is killed while the file is finished leaves it as after one of these writings."""
    writer = VideoWriter(tmp_path / f"out{ending}", 25)
    for index in range(30):
        writer.write(picture(index))
    put, counts = PartialFile._put, []

    def looking(self: PartialFile, place: int, data: bytes | memoryview) -> None:
        put(self, place, data)
        with open_source(self.path) as source:
            counts.append(len(list(source)))
        assert source.report.problems is None

    monkeypatch.setattr(PartialFile, "_put", looking)
    writer.close()
    assert len(counts) > 2
    assert min(counts) >= 29
    assert counts[-1] == 30


@pytest.mark.slow
@pytest.mark.parametrize("ending", KINDS)
def test_a_full_disk_is_one_clear_error(tmp_path: Path, ending: str) -> None:
    result = run(
        tmp_path,
        f"""
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
        written = 0
        try:
            with VideoWriter("out{ending}", 25) as writer:
                for index in range(1000):
                    writer.write(noise(index))
                    written += 1
        except FormatError as error:
            print(error)
        print(written)
        """,
    )
    assert result.stderr == ""
    message, written = result.stdout.splitlines()
    assert os.strerror(errno.EFBIG) in message
    assert "make room" in message
    assert f"is in {left(tmp_path).name}." in message
    with open_source(left(tmp_path)) as source:
        kept = len(list(source))
    assert source.report.problems is None
    assert kept > 10
    assert kept >= int(written) - 2


@pytest.mark.slow
@pytest.mark.parametrize("ending", KINDS)
def test_a_disk_that_is_full_only_in_the_end_keeps_the_partial_file(
    tmp_path: Path, ending: str
) -> None:
    result = run(
        tmp_path,
        f"""
        writer = VideoWriter("out{ending}", 25)
        for index in range(60):
            writer.write(noise(index))
        size = writer.result.stat().st_size
        resource.setrlimit(resource.RLIMIT_FSIZE, (size + 100, size + 100))
        try:
            writer.close()
        except FormatError as error:
            print(error)
        """,
    )
    assert "make room" in result.stdout, result.stderr
    assert result.stderr == ""
    assert left(tmp_path).name in result.stdout
    with open_source(left(tmp_path)) as source:
        assert len(list(source)) >= 59
    assert source.report.problems is None


def test_a_disk_that_is_full_from_the_start_keeps_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(monkeypatch, "out.mp4")
    with pytest.raises(FormatError) as caught, VideoWriter(tmp_path / "out.mp4", 25) as writer:
        writer.write(picture(0))
    assert str(caught.value).endswith("make room there.")
    assert writer.result is None
    assert os.listdir(tmp_path) == []


def test_a_film_does_not_replace_what_appeared(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    writer = VideoWriter(path, 25)
    writer.write(picture(0))
    path.write_text("precious")
    with pytest.raises(FormatError, match=r"out\.mp4 appeared .*; the video is in .*partial-"):
        writer.close()
    assert path.read_text() == "precious"
    assert writer.result is not None
    with open_source(writer.result) as source:
        assert len(list(source)) == 1
