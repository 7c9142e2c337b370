"""Films in any order: their frames are those of a source, and little is decoded and kept."""

import gc
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from clips import spoil
from coded import KINDS, video
from motes import SourceError, open_source
from motes.video import DamagedError, Film, Seeker, film as film_module
from motes.video.decoder import Decoder
from motes.video.film import Shared, shared
from motes.video.report import Report, Stamped


@pytest.mark.parametrize("kind", KINDS)
def test_any_order_gives_the_frames_of_the_source(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    codec, ending, options = KINDS[kind]
    path = video(tmp_path / f"film.{ending}", codec, options)
    expected = [*open_source(path)]
    film = Film(path)
    assert film.frames == range(len(expected))
    assert film.times == [frame.time for frame in expected]
    monkeypatch.setattr(film_module, "PART", 3 * 48 * 64 * 4)  # four frames at a time
    last = len(expected) - 1
    order = [*film.backward(last, 0), *film.forward(11, 20), film.frame(13)]
    assert [frame.index for frame in order] == [*range(last, -1, -1), *range(11, 21), 13]
    for frame in order:
        assert (frame.pixels == expected[frame.index].pixels).all(), frame
        assert frame.time == expected[frame.index].time


def test_a_film_that_changes_meanwhile(tmp_path: Path) -> None:
    path = video(tmp_path / "film.avi", "mjpeg", {})
    film = Film(path)
    video(path, "mjpeg", {}, frames=10)
    with pytest.raises(SourceError, match="has fewer frames than before"):
        film.frame(20)


@pytest.mark.parametrize("kind", KINDS)
def test_a_quick_film_is_the_same_film(tmp_path: Path, kind: str) -> None:
    codec, ending, options = KINDS[kind]
    path = video(tmp_path / f"film.{ending}", codec, options)
    quick, film = Film(path, quick=True), Film(path)
    assert quick.times == film.times
    assert (quick.width, quick.height, quick.fps) == (film.width, film.height, film.fps)
    last = len(film.times) - 1
    for first, frames in ((0, film.forward(0, last)), (11, film.forward(11, last))):
        for expected, frame in zip(frames, quick.forward(first, last), strict=True):
            assert (frame.index, frame.time) == (expected.index, expected.time)
            assert (frame.pixels == expected.pixels).all()
    pictures = [frame.pixels for frame in film.forward(0, last)]
    backward = [frame.pixels for frame in quick.backward(20, 5)]
    assert all((pictures[20 - i] == each).all() for i, each in enumerate(backward))
    seeker = Seeker(quick)
    for place in [0, 29, 29, *range(5, 15), *random.Random(0).choices(range(30), k=30)]:
        assert (seeker.pixels(place) == pictures[place]).all(), place
    seeker.close()


def test_a_quick_film_decodes_only_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = video(tmp_path / "film.mp4", "libx264", {"g": "8"})
    decoded = list[int]()
    original = Decoder._decoded

    def counted(self: Decoder, packet: Any, report: Report) -> Iterator[Stamped]:
        for each in original(self, packet, report):
            decoded.append(1)
            yield each

    monkeypatch.setattr(Decoder, "_decoded", counted)
    film = Film(path, quick=True)
    assert len(film.times) == 30
    assert len(decoded) <= 2
    assert film.keys == [0, 8, 16, 24]


def test_damage_shows_when_a_quick_film_meets_it(tmp_path: Path) -> None:
    path = spoil(video(tmp_path / "film.mp4", "libx264", {"g": "8"}), 14, 1)
    film, whole = Film(path, quick=True), Film(path)
    assert len(whole.times) < len(film.times)
    for first, last in ((0, len(film.times) - 1), (10, 20)):
        with pytest.raises(DamagedError, match="is read as a whole"):
            [*film.forward(first, last)]
    assert [*film.forward(0, 3)]
    seeker, found = Seeker(whole), [frame.pixels for frame in whole.forward(0, 28)]
    for index in (20, 3, 15, 16, 0, 28):
        assert np.array_equal(seeker.pixels(index), found[index])


def test_read_backward_no_picture_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading a display matrix keeps the picture that has it; it is read once for a film."""
    film = Film(video(tmp_path / "film.mp4", "libx264", {"g": "8"}))
    monkeypatch.setattr(film_module, "PART", 3 * 3 * film.width * film.height)
    gc.collect()
    gc.disable()
    try:
        before = _pictures()
        seen = [frame.index for frame in film.backward(film.frames.stop - 1, 0)]
        assert _pictures() == before
    finally:
        gc.enable()
    assert len(seen) == 30


def _pictures() -> int:
    return sum(isinstance(each, av.VideoFrame) for each in gc.get_objects())


@pytest.fixture
def film(tmp_path: Path) -> Film:
    return Film(video(tmp_path / "film.mp4", "libx264", {"g": "8"}))


def test_frames_are_those_of_the_film_and_are_decoded_once(
    film: Film, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = [*film.forward(5, 20)]
    loads, begun = Film.loads, list[int]()

    def counted(self: Film, first: int) -> Iterator[object]:
        begun.append(first)
        return loads(self, first)

    monkeypatch.setattr(Film, "loads", counted)
    reader = shared(film, 5, 20)
    read = [*reader.forward(20, 20), *reader.forward(5, 20), *reader.backward(20, 5)]
    assert begun == [5]
    assert [frame.index for frame in read] == [20, *range(5, 21), *range(20, 4, -1)]
    for frame in read:
        assert (frame.pixels == expected[frame.index - 5].pixels).all()
        assert frame.time == film.times[frame.index]


def test_a_part_is_decoded_from_the_last_key_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the beginning, 30 pictures in parts of four would take 144."""
    film = Film(video(tmp_path / "film.mp4", "libx264", {"g": "8", "bf": "0"}))
    decoded = 0
    numbered = Film._numbered

    def counted(self: Film, pictures: Any, first: int | None) -> Any:
        def each() -> Any:
            nonlocal decoded
            for picture in pictures:
                decoded += 1
                yield picture

        return numbered(self, each(), first)

    monkeypatch.setattr(Film, "_numbered", counted)
    monkeypatch.setattr(film_module, "PART", 3 * 48 * 64 * 4)
    assert len([*film.backward(29, 0)]) == 30
    assert decoded < 70


def test_memory_is_bounded(film: Film, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film_module, "HELD", 3 * film.width * film.height * 10)
    assert isinstance(shared(film, 5, 14), Shared)
    assert shared(film, 5, 15) is film
