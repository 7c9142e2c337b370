"""Images of every kind become RGB."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from motes import Scene, SourceError, Tracker, Trackers, kernels
from motes.core.frame import Frame, _readable, _say, as_frame, as_rgb

RGB = np.random.default_rng(0).integers(0, 256, (6, 9, 3), np.uint8)


@pytest.mark.parametrize(
    "image",
    [
        RGB,
        RGB[:, :, ::-1],
        RGB[::2, ::3],
        RGB[:, 4:5],
        RGB[1:, 2:4, :1],
        np.zeros((3, 5, 4), np.uint8)[:, :, 2::-1],
    ],
)
def test_what_lies_pixel_after_pixel_and_row_after_row_is_not_copied(image: Any) -> None:
    rgb = as_rgb(image)
    assert np.shares_memory(rgb, image)
    assert as_rgb(rgb) is rgb
    channels = image if image.ndim == 3 else image[:, :, None]
    np.testing.assert_array_equal(rgb, np.broadcast_to(channels[:, :, :3], rgb.shape))
    out = np.empty((3, *rgb.shape[:2]), np.float32)
    kernels.search_window.cut(rgb, (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), out)
    np.testing.assert_array_equal(out.transpose(1, 2, 0), rgb)


@given(hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=9)))
def test_gray(image: Any) -> None:
    for form in (image, image[:, :, None]):
        rgb = as_rgb(form)
        assert rgb.shape == (*image.shape, 3)
        for channel in range(3):
            np.testing.assert_array_equal(rgb[:, :, channel], image)


def test_floats_and_sixteen_bits_become_bytes() -> None:
    for kind in (np.float16, np.float64):
        np.testing.assert_array_equal(as_rgb((RGB / 255).astype(kind)), RGB)
    image = np.array([[0, 255, 256, 65535]], np.uint16)
    np.testing.assert_array_equal(as_rgb(image)[0, :, 0], [0, 0, 1, 255])
    np.testing.assert_array_equal(as_rgb(RGB.astype(np.uint16) << 8), RGB)


def test_values_of_fewer_bits_in_sixteen_keep_their_shades(tmp_path: Path) -> None:
    """8 or 12 bits in uint16 are no black pictures; the first one of a film decides for all."""
    np.testing.assert_array_equal(Frame(0, 0.0, RGB.astype(np.uint16)).pixels, RGB)
    deep: Any = RGB.astype(np.uint16) << 2
    tracker, scene = Tracker("mean_shift"), Scene(lambda frame: [])
    tracker.init(deep, (1, 1, 4, 3))
    scene.update(deep)
    tracker.save(tmp_path / "saved")
    group = Trackers("mean_shift")
    group.init(deep, [(1, 1, 4, 3)])
    of_group = partial(group._picture, last=group._last)
    lasts = tracker._frame, Tracker.load(tmp_path / "saved")._frame, scene._last
    for frame_of in (of_group, *(partial(as_frame, last=last) for last in lasts)):
        np.testing.assert_array_equal(frame_of(deep).pixels, RGB)
        np.testing.assert_array_equal(frame_of(deep >> 3).pixels, RGB >> 3)
        assert frame_of(deep << 3).pixels.max() == 255
    stuck = np.full((200, 200), 300, np.uint16)
    stuck[0, 0] = 65535
    assert as_rgb(stuck).min() == 300 >> 2
    with pytest.raises(SourceError, match="depth"):
        as_rgb(deep, 11)


def test_a_dark_first_picture_is_said(caplog: pytest.LogCaptureFixture) -> None:
    """Depth cameras begin before their light does: then all later pictures would be white."""
    _say.cache_clear()
    dark: Any = RGB.astype(np.uint16)
    first = as_frame(dark)
    for image in (dark, dark << 4, dark << 4):
        as_frame(image, first)
    assert [text[:22] for text in caplog.messages] == [
        "the pictures use 8 of ",
        "a picture is too brigh",
    ]
    caplog.clear()
    assert as_frame(dark << 8, Frame(0, 0.0, dark, depth=16)).pixels.max() == RGB.max()
    assert not caplog.messages
    as_frame(Frame(1, 0.04, dark << 4), first)  # whose bits are found anew
    assert caplog.messages[-1].startswith("frame 1 uses 12 bits, those before 8")


@pytest.mark.parametrize(
    "image",
    [
        RGB[:, ::-1],
        RGB[::-1],
        np.asfortranarray(RGB),
        np.broadcast_to(RGB[:1], RGB.shape),
        np.dstack([RGB, RGB])[:, :, ::2],
        np.lib.stride_tricks.as_strided(RGB, (2, 2, 3), (3, 6, 1)),
        np.lib.stride_tricks.as_strided(RGB, (2, 2, 3), (9, 2, 1)),
    ],
)
def test_what_lies_otherwise_is_copied(image: Any) -> None:
    rgb = as_rgb(image)
    assert rgb.flags.c_contiguous
    np.testing.assert_array_equal(rgb, image)
    with pytest.raises(TypeError, match="must be a picture that as_rgb returns"):
        kernels.search_window.cut(
            image, (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), np.empty((3, 2, 2), np.float32)
        )


def test_a_view_whose_places_need_more_than_32_bits_is_copied() -> None:
    image = np.lib.stride_tricks.as_strided(RGB, (3, 2, 3), (2**30, 3, 1))
    assert not _readable(image)
    assert _readable(image[:1])


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (None, "no picture, but None"),
        (np.zeros(5, np.uint8), "shape"),
        (np.zeros((0, 4, 3), np.uint8), "shape"),
        (np.zeros((4, 4, 3), np.int64), "int64"),
        (np.full((4, 4, 3), "x"), "Convert it"),
        (np.full((4, 4), 255.0), "0 to 1"),
        (np.full((4, 4), -0.1), "0 to 1; got -0.1 to -0.1"),
        (np.full((4, 4), np.nan), "NaN"),
        ("film.mp4", "or 4\\); got str"),
    ],
)
def test_no_images(image: Any, message: str) -> None:
    with pytest.raises(SourceError, match=message):
        as_rgb(image)


@pytest.mark.parametrize("time", [None, "0.5", [1.0]])
def test_a_time_is_a_number(time: Any) -> None:
    with pytest.raises(SourceError, match=r"^Frame 3 has the time .*; give it seconds"):
        Frame(3, time, np.zeros((4, 5, 3), np.uint8))
    assert Frame(3, np.float32(0.5), np.zeros((4, 5, 3), np.uint8)).time == 0.5  # type: ignore[arg-type]


@pytest.mark.parametrize("index", [None, "1", 1.5])
def test_an_index_is_a_whole_number(index: Any) -> None:
    with pytest.raises(SourceError, match="index is a whole number"):
        Frame(index, 0.0, np.zeros((4, 5, 3), np.uint8))


@pytest.mark.parametrize(("step", "index", "time"), [(1, 6, 0.24), (-1, 4, 0.16)])
def test_an_image_follows_the_last_frame(step: int, index: int, time: float) -> None:
    found = as_frame(RGB, Frame(5, 0.2, RGB), step)
    assert found.index == index
    assert found.time == pytest.approx(time)
