"""A server that ends, and another one that goes on."""

from __future__ import annotations

from pathlib import Path

import pytest

from motes.studio import protocol
from studios import FRAMES, begin, film, looking, running

pytestmark = pytest.mark.slow


def test_a_run_of_many_objects_goes_on_after_a_restart(tmp_path: Path) -> None:
    folder = tmp_path / "films"
    folder.mkdir()
    film(folder / "film.mkv")
    with running(folder, tmp_path / "data") as client:
        session = begin(client)
        with looking(client, session) as page:
            job = page.do("watch", seed=2).job
            page.do("pause", job=job)
    for _ in range(2):  # once it has ended, it does not begin again
        with running(folder, tmp_path / "data") as client, looking(client, session) as page:
            page.until(lambda: all(each.status == "done" for each in page.jobs.values()))
            page.until(
                lambda: sum(len(rows.frames) for rows in page.of(protocol.SceneRows)) == FRAMES
            )
            found = [*page.jobs.values()]
    assert not found
