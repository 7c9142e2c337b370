"""The comparison of tracks across machines finds none on one machine, and finds one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scripts import script


def test_the_same_machine_has_the_same_tracks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    same_tracks = script("benchmarks/same_tracks.py")
    monkeypatch.setattr(same_tracks, "FRAMES", 2)
    monkeypatch.setattr(same_tracks, "NAMES", ("nummiaro",))
    file = tmp_path / "tracks.npz"
    same_tracks.write(file)
    with np.load(file) as stored:
        values = dict(stored)
    values["ng_delp"] = values["ng_delp"] + 0.5
    np.savez(file, **values)
    same_tracks.compare(file)
    lines = [line.rsplit(maxsplit=1) for line in capsys.readouterr().out.splitlines()[1:]]
    assert {name: float(difference) for name, difference in lines} == {
        "nummiaro": 0,
        "ng_delp": 0.5,
        "ng_delp, all pixels": 0,
        "ng_delp, half": 0,
        "ng_delp, quarter": 0,
    }
