"""Frames that several passes read: those of the film, decoded once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from coded import video
from motes.video import frame_sharing as shared_module
from motes.video.film import Film
from motes.video.frame_sharing import Shared, shared


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


def test_memory_is_bounded(film: Film, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_module, "HELD", 3 * film.width * film.height * 10)
    assert isinstance(shared(film, 5, 14), Shared)
    assert shared(film, 5, 15) is film
