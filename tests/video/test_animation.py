"""Image files that hold several pictures are read whole, or it is said what is left out."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from clips import picture
from motes import SourceError, open_source

IMAGES = [Image.fromarray(picture(index)) for index in range(5)]
SHOWN = [40, 120, 20, 40, 40]
"""Milliseconds."""


def save(path: Path, form: str | None = None, **options: object) -> Path:
    first, *rest = (image.copy() for image in IMAGES)
    first.save(path, form, save_all=True, append_images=rest, **options)
    return path


@pytest.mark.parametrize(
    ("name", "form"), [("a.png", "PNG"), ("a.webp", "WEBP"), ("gif.png", "GIF")]
)
def test_an_animation_is_read_whole_at_its_own_times(tmp_path: Path, name: str, form: str) -> None:
    options = {"lossless": True} if form == "WEBP" else {}
    path = save(tmp_path / name, form, duration=SHOWN, **options)
    with open_source(path) as source:
        assert source.frame_count == 5
        assert source.fps is not None
        frames = list(source)
        assert source.report.problems is None
    times = [sum(SHOWN[:index]) / 1000 for index in range(5)]
    assert [frame.time for frame in frames] == pytest.approx(times)
    for frame in frames:
        error = np.abs(frame.pixels.astype(int) - picture(frame.index)).max()
        assert error <= (0 if form in ("PNG", "WEBP") else 80)
    with open_source(path, start=1, end=4, stride=2) as source:
        assert [frame.time for frame in source] == pytest.approx(times[1:4:2])


def test_the_pages_of_a_tiff_are_read_but_not_their_thumbnails(tmp_path: Path) -> None:
    with open_source(save(tmp_path / "a.tiff")) as source:
        frames = list(source)
    assert [frame.time for frame in frames] == pytest.approx([0, 0.04, 0.08, 0.12, 0.16])
    assert all(np.array_equal(frame.pixels, picture(frame.index)) for frame in frames)

    thumbnail, tags = Image.fromarray(picture(9, 32, 24)), ImageFileDirectory_v2()
    tags[254] = 1
    thumbnail.encoderinfo = {"tiffinfo": tags}
    IMAGES[0].save(tmp_path / "one.tiff", save_all=True, append_images=[thumbnail])
    with Image.open(tmp_path / "one.tiff") as image:
        assert image.n_frames == 2  # type: ignore[attr-defined]
    with open_source(tmp_path / "one.tiff") as source:
        assert [frame.pixels.shape for frame in source] == [(48, 64, 3)]


@pytest.mark.parametrize(
    ("about", "film"),
    [
        ("ImageJ=1.53t\nimages=5\n", True),
        ("ImageJ=1.53t\nimages=5\nslices=5\n", True),
        ("ImageJ=1.53t\nimages=5\nframes=5\n", True),
        ("ImageJ=1.53t\nimages=4\nchannels=2\nframes=2\nhyperstack=true\n", False),
        ("ImageJ=1.53t\nimages=5\nchannels=5\nmode=grayscale\n", False),
        ("ImageJ=1.53t\nimages=4\nslices=2\nframes=2\nhyperstack=true\n", False),
        ('<OME><Pixels SizeC="3" SizeT="5" SizeZ="1"/></OME>', True),  # of colors
        ('<OME><Pixels SizeC="1" SizeT="1" SizeZ="5"/></OME>', True),
        ('<OME><Pixels SizeC="2" SizeT="2" SizeZ="1"/></OME>', False),
        ('<OME><Pixels SizeC="5" SizeT="1" SizeZ="1"/></OME>', False),
    ],
)
def test_channels_or_depths_that_take_turns_are_no_film(
    tmp_path: Path, about: str, film: bool
) -> None:
    path = save(tmp_path / "a.tiff", description=about)
    if not film:
        with pytest.raises(
            SourceError, match=r"5 pictures of [12] moments?: its channels or depths"
        ):
            open_source(path)
        return
    with open_source(path) as source:
        assert len(list(source)) == 5


@pytest.mark.parametrize(
    ("about", "step"),
    [
        ("ImageJ=1.53t\nimages=5\nframes=5\nfps=7.0\nfinterval=0.5\n", 0.5),
        ("ImageJ=1.53t\nimages=5\nfinterval=2.5E-1\ntunit=sec\nunit=micron\n", 0.25),
        ("ImageJ=1.53t\nimages=5\nfinterval=500\ntunit=ms\n", None),
        ("ImageJ=1.53t\nimages=5\nfinterval=0.0\n", None),
        ('<OME><Pixels SizeT="5" TimeIncrement="2" TimeIncrementUnit="s"/></OME>', 2),
        ('<OME><Pixels SizeT="5" TimeIncrement="2" TimeIncrementUnit="min"/></OME>', None),
    ],
)
def test_pages_are_as_far_apart_as_a_microscope_tells(
    tmp_path: Path, about: str, step: float | None
) -> None:
    with open_source(save(tmp_path / "a.tiff", description=about)) as source:
        assert [frame.time for frame in source] == pytest.approx(
            [(step or 0.04) * n for n in range(5)]
        )
    assert [source.fps, bool(source.report.assumption)] == [step and 1 / step, step is None]


def test_the_picture_for_other_programs_is_no_part_of_an_animation(tmp_path: Path) -> None:
    path = save(tmp_path / "a.png", default_image=True, duration=40)
    with open_source(path) as source:
        frames = list(source)
    assert [frame.time for frame in frames] == pytest.approx([0, 0.04, 0.08, 0.12])
    assert np.array_equal(frames[0].pixels, picture(1))


def test_an_animation_among_images_does_not_pass_for_one_of_them(tmp_path: Path) -> None:
    IMAGES[0].save(tmp_path / "1.png")
    save(tmp_path / "2.png", duration=40)
    save(tmp_path / "3.tiff")
    for where in (tmp_path, tmp_path / "*"):
        with open_source(where) as source:
            assert len(list(source)) == 3
            assert source.report.left_out == 8
            assert "8 picture(s) left out" in (source.report.problems or "")
    with open_source(tmp_path / "2.png") as source:
        assert np.array_equal(next(source).pixels, picture(0))


def test_the_other_pictures_of_a_phones_photograph_are_no_film(tmp_path: Path) -> None:
    """They show the same moment: another eye, a preview, how bright it was."""
    with open_source(save(tmp_path / "a.jpg", "MPO")) as source:
        assert len(list(source)) == 1


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.float32(3), "from 0 to 1; got 3 to 3"),
        (np.int32(65536), "to 65536"),
        (np.int32(-1), "from -1"),
    ],
)
def test_values_that_are_none_of_a_picture_are_told_with_the_file(
    tmp_path: Path, value: np.generic, reason: str
) -> None:
    Image.fromarray(np.full((8, 8), value)).save(tmp_path / "f.tif")
    for source in (tmp_path, tmp_path / "f.tif"):
        with (
            pytest.raises(SourceError, match=rf"f\.tif: .* {reason}"),
            open_source(source) as frames,
        ):
            next(iter(frames))


@pytest.mark.parametrize("name", ["a.png", "a.webp", "a.tiff", "gif.png"])
def test_a_cut_animation_is_never_a_shorter_one(tmp_path: Path, name: str) -> None:
    path = save(tmp_path / name, "GIF" if "gif" in name else None, duration=40)
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * 0.7)])
    with pytest.raises(SourceError, match="cannot be read") as caught, open_source(path) as source:
        list(source)
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)


def test_an_image_that_is_too_large_is_refused_as_such(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    IMAGES[0].save(tmp_path / "a.png")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 64 * 48 // 2 - 1)
    with pytest.raises(SourceError, match="too large: more than 3070 pixels"):
        open_source(tmp_path / "a.png")
