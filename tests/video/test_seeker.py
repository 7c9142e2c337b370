"""Single frames: the pixels are those of the film, and little is decoded for them."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from coded import KINDS, video
from motes.video.decoder import Decoder
from motes.video.film import Film
from motes.video.seeker import Seeker


@pytest.mark.parametrize("kind", KINDS)
def test_frames_in_any_order_are_those_of_the_film(tmp_path: Path, kind: str) -> None:
    codec, ending, options = KINDS[kind]
    path = video(tmp_path / f"film.{ending}", codec, options)
    expected = [frame.pixels for frame in Film(path).forward(0, 29)]
    seeker = Seeker(Film(path, quick=True))
    places = [0, 29, 29, *range(5, 15), *random.Random(0).choices(range(30), k=30)]
    for place in places:
        assert (seeker.pixels(place) == expected[place]).all(), place
    seeker.close()


def test_the_nearest_place_is_gone_on_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the key picture before it each time, 30 frames of one group would take over 200."""
    seeker = Seeker(Film(video(tmp_path / "film.mp4", "libx264", {"g": "250"}), quick=True))
    packets = list[bool]()
    decoded = Decoder._decoded

    def counted(self: Decoder, packet: Any, report: Any) -> Any:
        packets.append(True)
        return decoded(self, packet, report)

    monkeypatch.setattr(Decoder, "_decoded", counted)
    for place in range(0, 30, 2):
        seeker.pixels(place)
    assert len(packets) <= 31
    packets.clear()
    seeker.pixels(3)
    assert 0 < len(packets) < 20
