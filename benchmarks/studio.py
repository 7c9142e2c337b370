"""How soon the studio answers: start, seek, overlays, corrections, eight sessions, memory.

    python benchmarks/studio.py [FILM] [--quick] [--only start,seek,...]

The film is one of 10 minutes at 1920x1080, rendered and encoded with x264 as FFmpeg does it by
default (a key picture every 250 frames) into the folder for temporary files, unless one is given.
It repeats 600 pictures. `--quick` takes a small, short film. The tracking is that of the preset
`default`. The studio runs in a process of its own, and a page without a browser asks.

A time is that of the page: from the request to the last byte of the answer. Memory is the sum of
the resident memory of the server and all its workers, without what they share.
"""

from __future__ import annotations

import itertools
import json
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import av
import httpx
import numpy as np
from websockets.sync.client import ClientConnection, connect

from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

SIZE, FRAMES, LOOP = (1920, 1080), 15_000, 600
HOUR = 240
"""Corrections of an hour, one each 15 seconds, without the pauses."""
Said = tuple[str, str]
"""What was measured, and what was found."""


def picture(index: int, size: tuple[int, int]) -> np.ndarray[Any, Any]:
    """Return a picture: a textured ground that drifts, and a red ellipse that goes around."""
    width, height = size
    x, y = np.arange(width) + 2 * (index % LOOP), np.arange(height)[:, None]
    ground = 120 + 50 * np.sin(x / 17) * np.sin(y / 13) + 40 * np.sin((x + y) / 5)
    out = np.repeat(ground[:, :, None], 3, axis=2).astype(np.uint8)
    angle = 2 * np.pi * index / LOOP
    center = width * (0.5 + 0.3 * np.sin(angle)), height * (0.5 + 0.3 * np.cos(angle))
    inside = ((np.arange(width) - center[0]) / 60) ** 2 + ((y - center[1]) / 40) ** 2 < 1
    out[inside] = 230, 40, 40
    return out


def render(path: Path, frames: int, size: tuple[int, int]) -> None:
    """Write a film: `LOOP` pictures are encoded, and their packets repeated."""
    part = path.with_suffix(".part.mp4")
    with av.open(str(part), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for index in range(min(LOOP, frames)):
            frame = av.VideoFrame.from_ndarray(picture(index, size), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    with av.open(str(path), "w") as out:
        copy, shift = None, 0
        for _ in range(-(-frames // LOOP)):
            with av.open(str(part)) as container:
                stream = container.streams.video[0]
                if copy is None:
                    copy = out.add_stream_from_template(stream)
                assert stream.time_base is not None
                step = int(1 / (25 * stream.time_base))
                for packet in container.demux(stream):
                    if packet.size and packet.pts is not None and packet.dts is not None:
                        packet.pts, packet.dts = packet.pts + shift, packet.dts + shift
                        packet.stream = copy
                        out.mux(packet)
                shift += min(LOOP, frames) * step
    part.unlink()


@contextmanager
def studio(folder: Path, data: Path) -> Iterator[tuple[str, int]]:
    """Run a studio, and give its address and its process."""
    words = [sys.executable, "-m", "motes", "studio", str(folder), "--data", str(data)]
    words += ["--port", "0", "--headless"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as running:
        try:
            assert running.stderr is not None
            line = running.stderr.readline()
            address = next(word for word in line.split() if word.startswith("http"))
            yield address.rstrip("/"), running.pid
        finally:
            running.terminate()


class Page:
    """A page: it takes all that comes, and knows when a job has ended."""

    def __init__(self, client: httpx.Client, film: str) -> None:
        found = client.post("/api/sessions", json={"film": film, "anew": True}).json()
        assert "id" in found, found
        self.session, self.frames = found["id"], found["film"]["frames"]
        address = str(client.base_url).replace("http", "ws").rstrip("/")
        self._opened = connect(f"{address}/api/sessions/{self.session}/ws", max_size=None)
        self.socket: ClientConnection = self._opened.__enter__()
        self._ids = itertools.count(1)
        self.overlays = 0

    def close(self) -> None:
        """Leave."""
        self._opened.__exit__(None, None, None)

    def ask(self, kind: str, **fields: Any) -> dict[str, Any]:
        """Send a command, and return its reply."""
        number = next(self._ids)
        self.socket.send(json.dumps({"type": kind, "id": number, **fields}))
        found = self.until(lambda m: m["type"] == "reply" and m["id"] == number)
        assert found["error"] is None, found
        return found

    def until(self, last: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Receive until a message is the last one, and return it."""
        while True:
            message: dict[str, Any] = json.loads(self.socket.recv(timeout=600))
            if message["type"] == "overlay":
                self.overlays += 1
                number = message["number"]
                self.socket.send(json.dumps({"type": "acknowledge", "id": 0, "number": number}))
            if last(message):
                return message

    def wait(self, *jobs: int) -> None:
        """Wait for the ends of jobs, in any order; their rows have come before."""
        left = {*jobs}
        while left:
            ended = self.until(
                lambda m: (
                    m["type"] == "progress"
                    and m["job"] in left
                    and m["status"] in ("done", "failed", "stopped")
                )
            )
            assert ended["status"] == "done", ended
            left.remove(ended["job"])

    def draw(self, frame: int, size: tuple[int, int], seed: int = 0) -> int:
        """Draw the ellipse of a frame, and return the number of the object."""
        fields: dict[str, Any] = {"name": "disk", "color": "#d55e00", "frame": frame, "seed": seed}
        fields["region"] = region(frame, size)
        return int(self.ask("add_object", **fields)["object"])

    def limit(self, number: int, frames: int, size: tuple[int, int]) -> None:
        """Let an object have only the first frames."""
        self.ask("set_keyframe", object=number, frame=frames, region=region(frames, size))
        rest = self.ask("split", object=number, frame=frames)["object"]
        self.ask("remove_object", object=rest)

    def correct(self, number: int, frame: int, size: tuple[int, int], shift: float = 0) -> float:
        """Correct a frame, and return the seconds until the smoothed rows are here."""
        clock = time.perf_counter()
        next_id = next(self._ids)
        fields = {"object": number, "frame": frame, "region": region(frame, size, shift)}
        command = {"type": "set_keyframe", "id": next_id, **fields}
        self.socket.send(json.dumps(command))
        state = self.until(lambda m: m["type"] == "state")
        active = [
            j["job"] for j in state["session"]["jobs"] if j["status"] in ("running", "waiting")
        ]
        self.wait(*active)
        return time.perf_counter() - clock


def region(frame: int, size: tuple[int, int], shift: float = 0) -> list[float]:
    """Return the box of the ellipse in a frame, moved to the right."""
    angle = 2 * np.pi * (frame % LOOP) / LOOP
    x, y = size[0] * (0.5 + 0.3 * np.sin(angle)), size[1] * (0.5 + 0.3 * np.cos(angle))
    return [x - 60 + shift, y - 40, 120, 80]


def resident(pid: int) -> float:
    """Return the megabytes of a process and its children, without what they share."""
    total = 0
    for process in [pid, *_children(pid)]:
        try:
            text = Path(f"/proc/{process}/smaps_rollup").read_text()
        except OSError:
            continue
        total += sum(
            int(line.split()[1]) for line in text.splitlines() if line.startswith("Private_")
        )
    return total / 1024


def _children(pid: int) -> list[int]:
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            child = int(path.parent.name)
            found += [child, *_children(child)]
    return found


def quantiles(seconds: list[float]) -> str:
    """Return the median and the 95 % quantile in words."""
    ordered = sorted(seconds)
    high = ordered[min(len(ordered) - 1, round(0.95 * len(ordered)))]
    return f"median {statistics.median(ordered):.3f} s, 95 % {high:.3f} s"


def start(folder: Path, rounds: int) -> Said:
    """Measure the time from the command to the page and the list of films."""
    times = []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as data:
            clock = time.perf_counter()
            with studio(folder, Path(data)) as (address, _pid):
                for path in ("/", "/api/films", "/api/presets", "/api/sessions"):
                    httpx.get(address + path).raise_for_status()
                times.append(time.perf_counter() - clock)
    return "page usable after start", quantiles(times)


def seek(client: httpx.Client, page: Page, count: int) -> list[Said]:
    """Measure seeks to frames anywhere, and those to neighbors; none is in a browser's cache."""
    rng = random.Random(0)
    times = []
    for _ in range(count):
        clock = time.perf_counter()
        path = f"/api/sessions/{page.session}/frames/{rng.randrange(page.frames)}.jpg?width=1280"
        client.get(path).raise_for_status()
        times.append(time.perf_counter() - clock)
    clock = time.perf_counter()
    for place in range(1000, 1100):
        client.get(f"/api/sessions/{page.session}/frames/{place}.jpg?width=1280")
    rate = 100 / (time.perf_counter() - clock)
    seeks = "seek to any frame, at first sight", quantiles(times)
    return [seeks, ("frames in order", f"{rate:.0f} a second")]


def tracking(page: Page, size: tuple[int, int], frames: int) -> list[Said]:
    """Measure overlays while an object is tracked."""
    number = page.draw(0, size)
    if frames < page.frames:
        page.limit(number, frames, size)
    page.overlays, clock = 0, time.perf_counter()
    page.wait(page.ask("track", objects=[number])["job"])
    seconds = time.perf_counter() - clock
    return [
        ("tracked", f"{frames / seconds:.0f} frames a second"),
        ("overlays meanwhile", f"{page.overlays / seconds:.0f} a second"),
    ]


def corrections(page: Page, size: tuple[int, int], rounds: int) -> Said:
    """Measure corrections in the middle of stretches of 100 frames, until the rows are here."""
    number = 1
    ends = range(0, 100 * rounds + 1, 100)
    for frame in ends[1:]:
        page.correct(number, frame, size)
    times = [page.correct(number, frame + 50, size, 2) for frame in ends[:-1]]
    return "correction to smoothed stretch of 100 frames", quantiles(times)


def sessions(client: httpx.Client, film: str, size: tuple[int, int], frames: int) -> Said:
    """Track in eight sessions at once, each with a seed of its own; compare with one after all."""
    pages = [Page(client, film) for _ in range(8)]
    rows: dict[int, bytes] = {}

    def follow(which: int) -> None:
        page = pages[which]
        number = page.draw(0, size, seed=which)
        page.limit(number, frames, size)
        page.wait(page.ask("track", objects=[number])["job"])
        path = f"/api/sessions/{page.session}/export?object={number}"
        rows[which] = client.get(path).content

    clock = time.perf_counter()
    threads = [threading.Thread(target=follow, args=(which,)) for which in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    seconds = time.perf_counter() - clock
    again = Page(client, film)
    number = again.draw(0, size, seed=5)
    again.limit(number, frames, size)
    again.wait(again.ask("track", objects=[number])["job"])
    alone = client.get(f"/api/sessions/{again.session}/export?object={number}").content
    same = alone == rows[5] and len(set(rows.values())) > 1
    for page in [*pages, again]:
        page.close()
        client.delete(f"/api/sessions/{page.session}")
    words = "rows as of one alone" if same else "ROWS DIFFER"
    return f"8 sessions at once, {frames} frames each", f"{seconds:.1f} s, {words}"


def memory(
    client: httpx.Client, page: Page, pid: int, size: tuple[int, int], steps: int, frames: int
) -> Said:
    """Correct, seek, look, undo and redo for an hour of use without its pauses."""
    rng = random.Random(1)
    known = []
    for step in range(steps):
        frame = rng.randrange(1, frames - 1)
        page.correct(1, frame, size, rng.uniform(-3, 3))
        for _ in range(10):
            place = rng.randrange(page.frames)
            client.get(f"/api/sessions/{page.session}/frames/{place}.jpg?width=1280")
        address = f"/api/sessions/{page.session}"
        client.get(f"{address}/doubts?object=1")
        client.get(f"{address}/overlays/{frame}?object=1")
        if step % 5 == 4:
            page.ask("undo")
            page.ask("redo")
        known.append(resident(pid))
    quarter = max(len(known) // 4, 1)
    early, late = (
        statistics.mean(part) for part in (known[quarter : 2 * quarter], known[-quarter:])
    )
    return (
        f"memory over {steps} corrections and {10 * steps} seeks",
        f"{early:.0f} MB in the second quarter, {late:.0f} MB in the last",
    )


def main(words: list[str]) -> None:
    quick = "--quick" in words
    only = words[words.index("--only") + 1].split(",") if "--only" in words else None
    size, frames = ((320, 240), 240) if quick else (SIZE, FRAMES)
    tracked = 120 if quick else 1200
    given = [word for word in words if Path(word).is_file()]
    with tempfile.TemporaryDirectory() as folder:
        films = Path(folder) / "films"
        films.mkdir()
        film = films / "film.mp4"
        if given:
            film.hardlink_to(given[0])
        else:
            render(film, frames, size)
        lines: list[Row] = []

        def show(*rows: Said) -> None:
            lines.extend((Cell(what), Cell(value)) for what, value in rows)

        def wanted(what: str) -> bool:
            return only is None or what in only

        if wanted("start"):
            show(start(films, 2 if quick else 10))
        with (
            studio(films, Path(folder) / "data") as (address, pid),
            httpx.Client(base_url=address, timeout=600) as client,
        ):
            page = Page(client, "film.mp4")
            if wanted("seek"):
                show(*seek(client, page, 10 if quick else 100))
            if wanted("track"):
                show(*tracking(page, size, tracked))
                show(corrections(page, size, 1 if quick else 10))
            if wanted("memory"):
                show(memory(client, page, pid, size, 4 if quick else HOUR, tracked))
            if wanted("sessions"):
                show(sessions(client, "film.mp4", size, 40 if quick else 100))
            page.close()
    title = f"The studio with a film of {size[0]}x{size[1]}"
    print(markdown.table(Table(title, ("what", "measured"), lines)))


if __name__ == "__main__":
    main(sys.argv[1:])
