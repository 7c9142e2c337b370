"""What lab/docs/reliability-tried.md tries that no test has the time for.

    python benchmarks/hazards.py film FILM.mp4 FRAMES
    python benchmarks/hazards.py memory SECONDS COMMAND ...
    python benchmarks/hazards.py returns TIMES
    python benchmarks/hazards.py signals SIGINT TIMES SECONDS
    python benchmarks/hazards.py events TIMES SECONDS

`film` renders the demo's clip at 320x240, to and fro. `memory` runs a command and prints, every
so many seconds, the memory of its process and of its children in MB, and their open handles.
`returns` is about a camera that goes away and comes back. `signals` sends a signal at a random
moment of the first so many seconds of a run, and counts exit codes and messages that are no
summary. `events` kills `motes watch` so many seconds after its first events at the most, and every
other time the MQTT broker too, and counts the events that do not arrive.
"""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path += [str(TESTS), str(TESTS / "mot")]

PICTURES = 15
"""Between two absences of the camera."""


def film(path: str, frames: str) -> None:
    """Write a long film in which nothing jumps, but what jumps in the demo."""
    from motes import synthetic
    from motes.video.writer import VideoWriter

    pixels = [frame.pixels for frame, _ in synthetic.demo((320, 240), 300)]
    around = pixels + pixels[-2:0:-1]
    with VideoWriter(path, 30) as writer:
        for index in range(int(frames)):
            writer.write(around[index % len(around)])


def signals(name: str, times: str, seconds: str) -> None:
    """Interrupt runs at random moments."""
    number, rng, ends = signal.Signals[name], random.Random(0), Counter[tuple[int, bool]]()
    signal.signal(number, signal.SIG_DFL)  # a shell may ignore it in the background, and all below
    run = "import sys; from motes.cli import main; print(flush=True); sys.exit(main())"
    with tempfile.TemporaryDirectory() as folder:
        film(f"{folder}/film.mp4", "3000")
        line = ["track", f"{folder}/film.mp4", "--init", "31,161,34,27", "--overwrite"]
        for _ in range(int(times)):
            program = subprocess.Popen(
                [sys.executable, "-c", run, *line, "-o", f"{folder}/rows.csv"],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            assert program.stdout is not None
            program.stdout.readline()
            time.sleep(rng.uniform(0, float(seconds)))
            program.send_signal(number)
            _, error = program.communicate()
            odd = [text for text in error.splitlines() if _is_odd(text)]
            ends[program.returncode, bool(odd)] += 1
            print(*odd, sep="\n", end="\n" if odd else "", file=sys.stderr)
    rows: list[Row] = [
        (Cell(name), Cell(f"{count}"), Cell(f"{code}"), Cell("yes" if strange else "no"))
        for (code, strange), count in sorted(ends.items())
    ]
    head = "signal", "runs", "exit code", "with other messages"
    print(markdown.table(Table("Runs that got a signal", head, rows)))


def events(times: str, seconds: str) -> None:
    """Kill runs that send events, and the broker."""
    import json

    import numpy as np

    from brokers import Broker, Listener, wait_until
    from motes.video.writer import VideoWriter
    from motes_fleet.delivery.delivery import Delivery
    from motes_fleet.delivery.event_queue import MessageQueue
    from motes_fleet.delivery.mqtt import Mqtt

    rng, noise = random.Random(0), np.random.default_rng(0)
    expected: set[tuple[str, ...]] = set()
    with tempfile.TemporaryDirectory() as folder, Broker(Path(folder)) as broker:
        path, queue = Path(folder, "film.mkv"), Path(folder, "queue")
        with VideoWriter(path, 25) as writer:
            for index in range(3000):
                pixels = noise.integers(95, 106, (96, 160, 3)).astype(np.uint8)
                x = 4 * (index % 60) - 16
                pixels[40:70, max(x, 0) : max(x + 16, 0)] = (230, 40, 40)
                writer.write(pixels)
        address = f"mqtt://127.0.0.1:{broker.port}/a"
        ears = Listener(broker.port, "a")

        def keys_heard() -> set[tuple[str, ...]]:
            heard = (json.loads(text) for text in ears.texts("a"))
            return {_key(event["source"], event) for event in heard}

        for number in range(int(times)):
            source, lines = Path(folder, f"{number}.mkv"), Path(folder, f"{number}.jsonl")
            source.symlink_to(path)
            line = ["watch", str(source), "--line", "80,0,80,96"]
            line += ["--events", str(lines), "--events", address, "--queue", str(queue)]
            with subprocess.Popen(
                [sys.executable, "-m", "motes", *line], stderr=subprocess.DEVNULL
            ) as program:
                wait_until(partial(_begun, lines))
                time.sleep(rng.uniform(0, float(seconds)))
                if number % 2:
                    broker.kill()
                    time.sleep(rng.uniform(0, 1))
                program.kill()
            if number % 2:
                broker.start()
            found = [json.loads(text) for text in lines.read_text().splitlines()]
            last = found[-1]["frame"]  # its events may not be in the queue yet
            keys = {_key(str(source), each) for each in found if each["frame"] < last}
            expected |= keys
        with MessageQueue(queue) as left:
            sending = Delivery(left, Mqtt(address), lambda line: None)
            wait_until(lambda: not left.waiting())
            sending.close()
        end = time.monotonic() + 5
        while time.monotonic() < end and not expected <= (heard := keys_heard()):
            time.sleep(0.1)
        texts = ears.texts("a")
        ears.close()
    twice = len(texts) - len({json.loads(text)["id"] for text in texts})
    print(f"{len(expected)} events, {len(expected - heard)} lost, {twice} arrived twice")


def _begun(path: Path) -> bool:
    """Return whether something is in a file."""
    return path.exists() and path.stat().st_size > 0


def _key(source: str, event: dict[str, Any]) -> tuple[str, ...]:
    """Return what tells an event from all others."""
    return source, *(str(event.get(name)) for name in ("frame", "event", "identity"))


def _is_odd(message: str) -> bool:
    """Return whether a line is not one of what a run says when it is interrupted."""
    return not message.startswith("motes: ") or "error:" in message


def memory(seconds: str, *command: str) -> None:
    """Watch a command's memory."""
    program = subprocess.Popen(command)
    while program.poll() is None:
        print(*_taken(_family(program.pid)), flush=True)
        time.sleep(float(seconds))
    print("exit code", program.returncode)


def _taken(processes: Iterable[int]) -> tuple[int, int]:
    """Return the memory in MB and the open handles of processes."""
    pages = handles = 0
    for each in processes:
        try:
            pages += int(Path(f"/proc/{each}/statm").read_text().split()[1])
            handles += len(os.listdir(f"/proc/{each}/fd"))
        except OSError:  # it has ended
            continue
    return pages * os.sysconf("SC_PAGE_SIZE") // 10**6, handles


def _family(pid: int) -> Iterator[int]:
    """Yield a process and all that it started."""
    yield pid
    for children in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in children.read_text().split():
            yield from _family(int(child))


def returns(times: str) -> None:
    """Let a camera go away and come back; print memory in MB and handles, and who was seen."""
    from motes.mot.scene import Scene
    from motes.video import Newest
    from motes.video.sources import open_source
    from motes_fleet.cameras.camera_reporter import CameraReporter
    from motes_fleet.cameras.live import on_clock
    from motes_fleet.cameras.reidentification import CrossCameraAssociation
    from motes_fleet.cameras.rig_config import Camera, Rig
    from red_box import red

    ours, theirs = multiprocessing.Pipe()
    away = multiprocessing.Event()
    multiprocessing.Process(target=_serve, args=(theirs, away), daemon=True).start()
    seen = Camera("one", "")
    lookout, handover = CameraReporter(seen, Scene(red)), CrossCameraAssociation(Rig((seen,)))
    gone = back = pictures = 0
    identities: set[int] = set()

    def hear(text: str) -> None:
        nonlocal back, pictures
        back += "is back" in text
        away.clear()
        pictures = 0

    with open_source(ours.recv(), on_drop=hear) as source, Newest(source) as frames:
        for frame in on_clock(frames, time.monotonic()):
            identities |= set(handover.update(lookout.report(frame)).values())
            pictures += 1
            if pictures == PICTURES and not away.is_set():
                if gone % 10 == 0:
                    print(gone, "times:", *_taken([os.getpid()]), flush=True)
                if gone == int(times):
                    break
                gone += 1
                away.set()
    print(f"{gone} times gone, {back} times back, identities {sorted(identities)}")


def _serve(pipe: Connection, away: Event) -> None:
    from red_box import moving
    from streams import camera

    with camera(moving) as stream:
        pipe.send(stream.url)
        while True:
            if away.is_set():
                stream.hung_up.set()
            else:
                stream.hung_up.clear()
            time.sleep(0.02)


if __name__ == "__main__":
    actions = {
        "film": film,
        "memory": memory,
        "returns": returns,
        "events": events,
        "signals": signals,
    }
    if len(sys.argv) < 3 or sys.argv[1] not in actions:
        sys.exit(__doc__)
    actions[sys.argv[1]](*sys.argv[2:])  # type: ignore[operator]
