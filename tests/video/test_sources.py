"""Reading: every kind of source, whole, cut, damaged, odd."""

import contextlib
import gc
import itertools
import os
import platform
import socket
import tempfile
import threading
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import numpy as np
import pytest
from av.stream import Disposition
from hypothesis import given, strategies as st
from PIL import Image

from clips import (
    Codec,
    clip,
    cut,
    damage,
    mark,
    noise,
    packets,
    picture,
    remuxed,
    silence,
    sound_only,
    spoil,
)
from motes import ConfigError, SourceError, open_source
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.video import decoder
from motes.video.decoder import MAX_BAD_PACKETS
from motes.video.report import Report
from streams import server


def read(source: str | Path, **selection: Any) -> tuple[list[Frame], Report]:
    with open_source(source, **selection) as frames:
        return list(frames), frames.report


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return clip(tmp_path_factory.mktemp("whole") / "whole.mp4", 12)


def error_of(source: str | int | Path, **selection: Any) -> str:
    """Return the message of the error that reading the source ends with, which is one line."""
    with pytest.raises(SourceError) as caught, open_source(source, **selection) as frames:
        list(frames)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_video_gives_its_pictures(whole: Path) -> None:
    with open_source(whole) as source:
        assert (source.width, source.height) == (64, 48)
        assert source.fps == 25
        assert source.frame_count == 12
        assert source.duration == pytest.approx(12 / 25)
        assert source.name == str(whole)
        assert not source.live
        frames = [next(source), *source]  # whoever has begun goes on
        with pytest.raises(SourceError, match=r"is read to its end; open it again to read it"):
            list(source)
    assert [frame.index for frame in frames] == list(range(12))
    assert [frame.time for frame in frames] == pytest.approx([i / 25 for i in range(12)])
    for frame in frames:
        assert frame.pixels.dtype == np.uint8
        assert frame.pixels.flags.c_contiguous
        assert frame.pixels.flags.writeable
        error = np.abs(frame.pixels.astype(int) - picture(frame.index))
        assert error.mean() < 5
    assert source.report.decoded == 12
    assert source.report.problems is None
    with pytest.raises(SourceError, match=r"whole\.\w+ is closed; open it again\.$"):
        next(source)


@given(st.integers(0, 14), st.none() | st.integers(1, 16), st.integers(1, 5))
def test_the_selection_is_a_slice(start: int, end: int | None, stride: int) -> None:
    expected = list(range(7))[start:end:stride]
    with tempfile.TemporaryDirectory() as folder:
        for index in range(7):
            Path(folder, f"{index}.ppm").write_bytes(b"P6 1 1 255\n" + bytes([index] * 3))
        if end is not None and end <= start:
            with pytest.raises(ConfigError, match="end"):
                open_source(folder, start=start, end=end, stride=stride)
        elif not expected:
            assert "smaller start" in error_of(folder, start=start, end=end, stride=stride)
        else:
            with open_source(folder, start=start, end=end, stride=stride) as source:
                assert source.frame_count == len(expected)
                frames = list(source)
            assert [frame.index for frame in frames] == expected
            assert [frame.pixels[0, 0, 0] for frame in frames] == expected
            assert [frame.time for frame in frames] == [i * FRAME_INTERVAL for i in expected]


@pytest.mark.parametrize("ending", ["mp4", "mkv"])
def test_variable_frame_rate_keeps_its_times(tmp_path: Path, ending: str) -> None:
    times = [0, 40, 50, 200, 230, 500, 510, 900, 1000, 1500]
    late = [5000 * (ending == "mkv") + each for each in times]  # times are counted from the first
    frames, report = read(clip(tmp_path / f"vfr.{ending}", 10, times_ms=late))
    assert [frame.time for frame in frames] == pytest.approx([t / 1000 for t in times])
    assert report.problems is None


def test_missing_time_stamps_are_replaced_and_counted(tmp_path: Path) -> None:
    # AVI stores no time stamps; those of reordered pictures are guessed, and wrong.
    frames, report = read(clip(tmp_path / "reordered.avi", 50))
    assert len(frames) == 50
    for frame, following in itertools.pairwise(frames):
        assert following.time - frame.time > 0.03
        assert frame.time == pytest.approx(frame.index / 25, abs=0.13)
    assert report.retimed > 0
    assert "time stamp" in (report.problems or "")


def test_time_stamps_that_jump_back_are_replaced_and_counted(tmp_path: Path) -> None:
    path = clip(tmp_path / "twice.ts", 20)
    path.write_bytes(path.read_bytes() * 2)
    frames, report = read(path)
    assert len(frames) == 40
    assert (np.diff([frame.time for frame in frames]) > 0.01).all()
    assert report.retimed == 20


def test_a_turned_photograph_is_upright_whoever_reads_it(tmp_path: Path) -> None:
    """FFmpeg attaches data that PyAV does not know, and then tells no more than the angle."""
    image = Image.fromarray(picture(0))
    exif = image.getexif()
    for orientation in (1, 3, 6, 8):
        exif[0x0112] = orientation
        image.save(tmp_path / "turned.jpg", exif=exif, quality=95)
        (tmp_path / "turned.bin").write_bytes((tmp_path / "turned.jpg").read_bytes())
        frames, _ = read(tmp_path / "turned.bin")
        error = np.abs(frames[0].pixels.astype(int) - read(tmp_path / "turned.jpg")[0][0].pixels)
        assert error.mean() < 4


@pytest.mark.parametrize(
    "matrix", [(0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0), (-1, 0, 0, 1), (0, 1, 1, 0)]
)
def test_a_turned_or_mirrored_video_is_shown_as_players_do(
    tmp_path: Path, matrix: tuple[int, int, int, int]
) -> None:
    path = clip(tmp_path / "flat.mp4", 2)
    flat, _ = read(path)
    a, b, c, d = matrix
    with open_source(mark(path, *matrix)) as source:
        shown = list(source)
        assert (source.width, source.height) == ((64, 48) if a else (48, 64))
    y, x = np.mgrid[:48, :64]
    across, down = a * x + c * y, b * x + d * y
    across, down = across - across.min(), down - down.min()
    for before, after in zip(flat, shown, strict=True):
        assert np.array_equal(after.pixels[down, across], before.pixels)


def test_pixels_that_are_not_square_are_left_so_and_said(tmp_path: Path) -> None:
    path = tmp_path / "wide.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.sample_aspect_ratio = Fraction(2)
        container.mux(stream.encode(av.VideoFrame.from_ndarray(picture(0), format="rgb24")))
        container.mux(stream.encode(None))
    frames, report = read(path)
    assert frames[0].pixels.shape == (48, 64, 3)
    assert report.aspect == 2
    assert "2.00 times as wide" in (report.problems or "")


@pytest.mark.parametrize("fps", [10, 50])
def test_a_raw_stream_without_times_has_the_rate_that_it_says(tmp_path: Path, fps: int) -> None:
    with open_source(clip(tmp_path / "raw.h264", 30, fps=fps)) as source:
        assert source.fps == fps
        frames = list(source)
    assert [frame.time for frame in frames] == pytest.approx([i / fps for i in range(30)])
    assert source.report.retimed == 30


@pytest.mark.parametrize(
    ("codec", "form", "ending", "limit"),
    [
        ("qtrle", "argb", "mov", 0),
        ("ffv1", "yuv420p10le", "mkv", 16),
        ("ffv1", "rgb48le", "mkv", 0),
        ("mjpeg", "yuvj420p", "avi", 25),
    ],
)
def test_pixel_forms_and_odd_sizes(
    tmp_path: Path, codec: Codec, form: str, ending: str, limit: int
) -> None:
    path = clip(tmp_path / f"odd.{ending}", 3, width=63, height=47, codec=codec, pix_fmt=form)
    frames, _ = read(path)
    assert len(frames) == 3
    for frame in frames:
        assert frame.pixels.shape == (47, 63, 3)
        expected = picture(frame.index, 63, 47)[12:, 16:]  # without the block's hard edge
        assert np.abs(frame.pixels[12:, 16:].astype(int) - expected).max() <= limit


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_cut_mp4_gives_all_frames_before_the_cut(tmp_path: Path, share: float) -> None:
    path = clip(tmp_path / "cut.mp4", 60, noisy=True)
    size = int(path.stat().st_size * share)
    complete = sum(position + length <= size for position, length in packets(path))
    assert 0 < complete < 58
    frames, report = read(cut(path, share))
    assert len(frames) == complete
    assert report.truncated
    assert "cut off at" in (report.problems or "")


def test_a_cut_file_that_ends_without_error_is_noticed(tmp_path: Path) -> None:
    path = clip(tmp_path / "cut.mkv", 60, noisy=True, options={"bf": "0"})
    frames, report = read(cut(path, 0.6))
    assert abs(len(frames) - 36) <= 3
    assert report.truncated
    assert report.ended == pytest.approx(len(frames) / 25, abs=0.05)
    assert report.expected == pytest.approx(60 / 25, abs=0.05)


def test_sound_that_outlasts_the_pictures_is_no_truncation(tmp_path: Path) -> None:
    path = tmp_path / "long.mkv"
    with av.open(str(path), "w") as container:
        pictures = container.add_stream("libx264", rate=25)
        pictures.width, pictures.height, pictures.pix_fmt = 64, 48, "yuv420p"
        sound = container.add_stream("pcm_s16le", rate=8000)
        for index in range(10):
            frame = av.VideoFrame.from_ndarray(picture(index), format="rgb24")
            container.mux(pictures.encode(frame))
        container.mux(pictures.encode(None))
        for _ in range(40):
            container.mux(sound.encode(silence(800)))
    with open_source(path) as source:
        assert source.duration == pytest.approx(4, abs=0.1)
        assert len(list(source)) == 10
        assert source.report.problems is None


@pytest.mark.parametrize("ending", ["mp4", "mkv"])
def test_a_row_of_bad_packets_is_skipped_but_not_a_longer_one(tmp_path: Path, ending: str) -> None:
    path = clip(tmp_path / f"spoiled.{ending}", MAX_BAD_PACKETS + 20, options={"g": "1", "bf": "0"})
    frames, report = read(spoil(path, 5, MAX_BAD_PACKETS))
    assert report.skipped == MAX_BAD_PACKETS
    assert "skipped" in (report.problems or "")
    assert len(frames) == 20
    half = MAX_BAD_PACKETS // 2 + 1
    _, report = read(spoil(spoil(path, 5, half), 6 + half, half))
    assert report.skipped == 2 * half
    message = error_of(spoil(path, 5, MAX_BAD_PACKETS + 1))
    assert "65 packets in a row" in message
    assert "after frame 4" in message


def test_a_file_without_a_next_packet_is_given_up(tmp_path: Path) -> None:
    path = clip(tmp_path / "raw.y4m", 30, width=128, height=96, codec="wrapped_avframe")
    before, mark, after = path.read_bytes().rpartition(b"FRAME")
    path.write_bytes(before + mark.lower() + after)
    assert "after frame 28" in error_of(path)


def test_a_change_of_size_in_a_video_is_refused(tmp_path: Path) -> None:
    path, other = clip(tmp_path / "a.ts", 10), clip(tmp_path / "b.ts", 10, width=80)
    path.write_bytes(path.read_bytes() + other.read_bytes())
    message = error_of(path)
    assert "Frame 10" in message
    assert "80x48" in message
    assert "64x48" in message


def test_what_is_no_video_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "words.mp4").write_text("hello\n" * 500)
    (tmp_path / "words.txt").write_text("hello\n" * 500)
    (tmp_path / "random.mkv").write_bytes(noise(0).tobytes())
    (tmp_path / "words.png").write_text("hello")
    (tmp_path / "nothing").mkdir()
    beheaded = clip(tmp_path / "beheaded.mp4", 5)
    beheaded.write_bytes(beheaded.read_bytes().replace(b"moov", b"lost"))
    for name, words in {
        "empty.mp4": "is empty",
        "words.mp4": "is not a video",
        "words.txt": "is a text",
        "random.mkv": "is not a video",
        "words.png": "not an image",
        "nothing": "no images in",
        "missing.mp4": "no file or folder",
        "missing/*.jpg": "no images in",
        "beheaded.mp4": "is not a video",
    }.items():
        message = error_of(tmp_path / name)
        assert words in message
        assert name in message
    assert "holds no video" in error_of(sound_only(tmp_path / "sound.wav"))
    inner = tmp_path / "nothing" / "img"
    inner.mkdir()
    Image.new("RGB", (8, 8)).save(inner / "1.png")
    assert error_of(tmp_path / "nothing").endswith(f"{tmp_path / 'nothing'}; try {inner}.")
    assert "ftp:// is not known" in error_of("ftp://example.org/a.mp4")


@pytest.mark.parametrize("text", ["ffconcat version 1.0\nfile whole.mp4\n",
                                  "\ufeff#EXTM3U\n#EXTINF:1,\nwhole.mp4\n"])  # fmt: skip
def test_a_playlist_that_passes_for_a_film_is_refused(tmp_path: Path, text: str) -> None:
    clip(tmp_path / "whole.mp4", 5)
    for name in ("list.mp4", "list.MKV", "list"):
        (tmp_path / name).write_text(text)
        assert "is a playlist, which names other files" in error_of(tmp_path / name)
    if text.startswith("ffconcat"):
        (tmp_path / "list.ffconcat").write_text(text)
        with open_source(tmp_path / "list.ffconcat") as film:
            assert len([*film]) == 5


def test_the_cover_of_a_record_is_no_video(tmp_path: Path) -> None:
    path = tmp_path / "record.flac"
    with av.open(str(path), "w") as container:
        sound = container.add_stream("flac", rate=8000)
        cover = container.add_stream("mjpeg", rate=1)
        cover.width, cover.height, cover.pix_fmt = 64, 48, "yuvj420p"
        cover.disposition = Disposition.attached_pic.value  # type: ignore[assignment]
        container.mux(cover.encode(av.VideoFrame.from_ndarray(picture(0), format="rgb24")))
        container.mux(cover.encode(None))
        container.mux(sound.encode(silence(800)))
        container.mux(sound.encode(None))
    with av.open(str(path)) as container:
        assert container.streams.video
    assert "holds no video" in error_of(path)


def test_what_may_not_be_read_is_refused() -> None:
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        path = Path(folder, "locked.mp4")
        path.write_bytes(b"x" * 100)
        path.chmod(0)
        root = os.geteuid() == 0
        if root:
            os.seteuid(65534)
        try:
            assert "Permission denied" in error_of(path)
        finally:
            if root:
                os.seteuid(0)


def test_nothing_is_said_on_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = clip(tmp_path / "damaged.mkv", 40, noisy=True)
    read(damage(path))
    read(cut(path, 0.5))
    (tmp_path / "words.mp4").write_text("hello")
    error_of(tmp_path / "words.mp4")
    assert capfd.readouterr() == ("", "")


def test_images_come_in_natural_order(tmp_path: Path) -> None:
    for index in (10, 2, 1):
        Image.fromarray(np.full((4, 6, 3), index, np.uint8)).save(tmp_path / f"img{index}.png")
    (tmp_path / "truth.txt").write_text("1,2,3,4")
    (tmp_path / "._img1.png").write_text("what a Mac leaves behind")
    for source in (tmp_path, tmp_path / "*.png", tmp_path / "*"):
        with open_source(source) as images:
            assert (images.width, images.height) == (6, 4)
            assert images.frame_count == 3
            frames = list(images)
        assert [frame.pixels[0, 0, 0] for frame in frames] == [1, 2, 10]
        assert [frame.time for frame in frames] == pytest.approx([0, 0.04, 0.08])
    frames, _ = read(tmp_path / "img2.png")
    assert len(frames) == 1


def test_a_bad_image_among_good_ones_is_named(tmp_path: Path) -> None:
    for index in range(3):
        Image.fromarray(picture(index)).save(tmp_path / f"{index}.png")
    whole = (tmp_path / "1.png").read_bytes()
    (tmp_path / "1.png").write_bytes(whole[: len(whole) // 2])
    assert "1.png" in error_of(tmp_path)
    Image.fromarray(picture(1, 32, 48)).save(tmp_path / "1.png")
    assert "Frame 1 of" in error_of(tmp_path)
    assert "32x48" in error_of(tmp_path)


def test_every_kind_of_image_becomes_rgb(tmp_path: Path) -> None:
    rgb = Image.fromarray(picture(0, 9, 7))
    deep = np.arange(63, dtype=np.uint16).reshape(7, 9) * 1000
    palette, gray = rgb.quantize(200), rgb.convert("L")
    palette.info["transparency"] = bytes([0] * 200)
    for name, image, expected in (
        ("rgba.png", rgb.convert("RGBA"), rgb),
        ("palette.png", palette, palette.convert("RGBA").convert("RGB")),
        ("gray.png", gray, gray.convert("RGB")),
        ("gray16.tif", Image.fromarray(deep), Image.fromarray((deep >> 8).astype(np.uint8))),
        ("cmyk.jpg", rgb.convert("CMYK"), None),
    ):
        image.save(tmp_path / name)
        out = read(tmp_path / name)[0][0].pixels
        assert out.shape == (7, 9, 3)
        assert out.dtype == np.uint8
        assert out.flags.c_contiguous
        assert out.flags.writeable
        if expected is not None:
            np.testing.assert_array_equal(out, expected.convert("RGB"), err_msg=name)


@pytest.mark.parametrize("kind", ["deep.tif", "folder", "film.mkv"])
def test_the_bits_that_a_film_of_16_uses_are_found_once_and_said(tmp_path: Path, kind: str) -> None:
    """Cameras of 10 to 12 bits are not read by their high byte, nor by a dark first picture.

    The bits are found though the title is no UTF-8.
    """
    shades = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64)
    pages = [np.zeros_like(shades), *[shades] * 7, shades * 4]
    source = tmp_path / kind
    if kind == "deep.tif":
        first, *rest = map(Image.fromarray, pages)
        first.save(source, save_all=True, append_images=rest)
    elif kind == "folder":
        source.mkdir()
        for number, page in enumerate(pages[:-1]):
            Image.fromarray(page).save(source / f"{number}.png")
    else:
        with av.open(str(source), "w") as container:
            container.metadata["title"] = "Zoe"
            stream = container.add_stream("ffv1", rate=25)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "gray16le"
            for number, page in enumerate(pages[:-1]):
                frame = av.VideoFrame.from_ndarray(page, format="gray16le")
                frame.pts, frame.time_base = number, Fraction(1, 25)
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
        source.write_bytes(source.read_bytes().replace(b"Zoe", b"Zo\xeb"))
    bits = 14 if kind == "deep.tif" else 12
    with open_source(source) as opened:
        frames = list(opened)
    assert not frames[0].pixels.any()
    np.testing.assert_array_equal(frames[1].pixels[:, :, 0], shades >> (bits - 8))
    assert f"use {bits} of 16 bits" in (opened.report.assumption or "")
    assert opened.report.problems is None
    with open_source(source, start=3) as opened:
        np.testing.assert_array_equal(next(opened).pixels, frames[3].pixels)


def test_pictures_that_are_too_bright_for_the_depth_are_counted(tmp_path: Path) -> None:
    for number in range(40):
        shade = 60000 if number == 17 else 900
        Image.fromarray(np.full((4, 4), shade, np.uint16)).save(tmp_path / f"{number}.png")
    with open_source(tmp_path) as source:
        assert {int(frame.pixels.max()) for frame in source} == {255, 900 >> 2}
    assert "1 picture(s) too bright for 10 bits" in (source.report.problems or "")


def test_gray_of_16_bits_or_floats_keeps_its_shades(tmp_path: Path) -> None:
    gray = np.arange(63, dtype=np.uint16).reshape(7, 9) * 1000
    (tmp_path / "deep.pgm").write_bytes(b"P5 9 7 65535\n" + gray.astype(">u2").tobytes())
    Image.fromarray((gray / 65535).astype(np.float32)).save(tmp_path / "float.tif")
    for name in ("deep.pgm", "float.tif"):
        shades = read(tmp_path / name)[0][0].pixels[:, :, 0].astype(int)
        assert np.abs(shades - gray / 257).max() <= 1


def test_a_missing_camera_is_refused() -> None:
    if Path("/dev/video0").exists():
        pytest.skip("there is a camera")
    assert "camera 0" in error_of(0)
    assert error_of("0") == error_of(0)


@pytest.mark.parametrize(
    ("system", "form", "address"),
    [
        ("Linux", "v4l2", "/dev/video1"),
        ("Darwin", "avfoundation", "1:none"),
        ("Windows", "dshow", "video=front"),
    ],
)
def test_a_camera_is_a_live_source(
    whole: Path, monkeypatch: pytest.MonkeyPatch, system: str, form: str, address: str
) -> None:
    raw = clip(whole.parent / "raw.m4v", 5, codec="mpeg4")  # as a camera: no length is known
    really_open, asked = av.open, []

    def fake_open(file: str, *, format: str, **rest: Any) -> Any:  # noqa: A002
        asked.append((format, file))
        return really_open(str(raw), format="m4v")

    devices = [
        SimpleNamespace(name="back", media_types=["video"]),
        SimpleNamespace(name="microphone", media_types=["audio"]),
        SimpleNamespace(name="front", media_types=["video"]),
    ]
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(av, "open", fake_open)
    monkeypatch.setattr(av, "enumerate_input_devices", lambda form: devices, raising=False)
    with open_source(1) as source:
        assert source.live
        assert source.frame_count is None
        assert source.name == "camera 1"
        assert next(source).pixels.shape == (48, 64, 3)
    assert asked == [(form, address)]
    if system == "Windows":
        assert "There is no camera 2" in error_of(2)


@contextlib.contextmanager
def sending(data: bytes, length: int, pause: float | None = None) -> Iterator[str]:
    """Serve data over HTTP as the start of `length` bytes, then say nothing, or trickle."""
    done = threading.Event()

    def answer(connection: socket.socket, number: int) -> None:
        if data:
            head = f"HTTP/1.1 200 OK\r\nContent-Length: {length}\r\n\r\n"
            connection.sendall(head.encode() + data)
        if len(data) < length:
            while not done.wait(pause):
                connection.sendall(b"\0")

    with server(answer) as url:
        yield url
    done.set()


def test_a_video_from_a_server(whole: Path) -> None:
    data = whole.read_bytes()
    with sending(data, len(data)) as url, open_source(url) as source:
        assert "secret" not in source.name
        assert not source.live
        assert len(list(source)) == 12


def test_an_mp4_with_its_index_at_the_end_needs_a_server_with_ranges(tmp_path: Path) -> None:
    data = remuxed(clip(tmp_path / "film.mp4", 10, width=160, height=120, noisy=True))
    with sending(data, len(data)) as url:
        assert "index at the end, which cannot be read from a server without" in error_of(url)
    whole = (tmp_path / "film.mp4").read_bytes()
    begin = whole[: whole.index(b"mdat") + 100]

    def hang_up(connection: socket.socket, number: int) -> None:
        head = f"HTTP/1.1 200 OK\r\nContent-Length: {len(whole)}\r\n\r\n"
        connection.sendall(head.encode() + begin)

    with server(hang_up) as url:  # with the index first, it is the network
        assert "check the address and the network" in error_of(url)


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["mp4", "avi"])
def test_a_server_that_stops_sending_is_noticed(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(decoder, "READ_TIMEOUT", 0.4)
    data = clip(tmp_path / f"stalls.{ending}", 60, noisy=True).read_bytes()
    with sending(data[: len(data) // 2], len(data)) as url, open_source(url) as source:
        with pytest.raises(SourceError, match="does not answer") as caught:
            list(source)
        assert source.report.decoded > 20
    assert "secret" not in str(caught.value)


def test_a_server_that_is_not_there_is_noticed() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    for scheme in ("http", "rtsp"):
        assert "Connection refused" in error_of(f"{scheme}://127.0.0.1:{port}/x")


def test_pictures_are_freed_at_once(tmp_path: Path) -> None:
    """A picture in a cycle of references would wait for Python's search for such cycles."""
    gc.collect()
    gc.disable()
    try:
        with open_source(clip(tmp_path / "a.mp4", 12)) as source:
            for _ in source:
                pass
        assert sum(isinstance(each, av.VideoFrame) for each in gc.get_objects()) < 4
    finally:
        gc.enable()


@pytest.mark.parametrize(
    ("name", "values"),
    [("start", [-1, True, "1", 10**20]), ("end", [0, 2.5]), ("stride", [0, 0.5, 2**63])],
)
def test_a_senseless_selection_is_refused(whole: Path, name: str, values: list[Any]) -> None:
    for value in values:
        with pytest.raises(ConfigError, match=name) as caught:
            open_source(whole, **{name: value})
        assert "\n" not in str(caught.value)


def test_a_start_beyond_the_end_is_refused_on_opening(whole: Path) -> None:
    with pytest.raises(SourceError, match="has 12 frames, none of them from 12 on"):
        open_source(whole, start=12)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("skipped", "2 unreadable packet(s) skipped"),
        ("damaged", "2 picture(s) damaged"),
        ("retimed", "2 missing or wrong time stamp(s) replaced"),
        ("left_out", "2 picture(s) left out, those after the first in an animated file"),
        ("brighter", "2 picture(s) too bright for 10 bits"),
        ("late", "2 frame(s) left out, as newer ones had come"),
        ("drops", "dropped 2 time(s)"),
        ("aspect", "pixels are 2.00 times as wide as high, and left so"),
    ],
)
def test_a_problem_is_told_by_itself(name: str, words: str) -> None:
    report = Report(depth=10)
    setattr(report, name, 2)
    assert report.problems == words
