"""How old the results of a live camera are: from the painting of a picture to its row.

    python benchmarks/latency.py 25 50 100 --seconds 20

A camera on this machine sends JPEGs of two squares that walk over HTTP, and `motes watch` reads it.
Ages are those of rows: from the painting of a picture until its row can be read from standard
output. The camera's own encoding counts too.
"""

from __future__ import annotations

import argparse
import io
import signal
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes_lab.report import markdown
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number

WIDTH, HEIGHT = 640, 480
WARM_UP = 3.0
"""Seconds at the start that do not count: the detector learns the background."""


def painted(index: int, rate: float, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a picture with two walkers."""
    pixels = background.copy()
    for y, speed in ((200, 90), (330, -140)):
        x = int(index / rate * speed) % (WIDTH + 80) - 60
        pixels[y : y + 90, max(x, 0) : max(x + 40, 0)] = (220, 60, 40)
    return pixels


class Camera:
    """Sends pictures at a rate to whoever asks, and notes when each was painted."""

    def __init__(self, rate: float) -> None:
        self.sent: list[float] = []
        owner = self
        rng = np.random.default_rng(0)
        background = rng.integers(90, 140, (HEIGHT // 8, WIDTH // 8, 3)).astype(np.uint8)
        background = background.repeat(8, axis=0).repeat(8, axis=1)

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=b")
                self.end_headers()
                begun = time.monotonic()
                for index in range(10**9):
                    time.sleep(max(0.0, begun + index / rate - time.monotonic()))
                    moment, data = time.monotonic(), io.BytesIO()
                    Image.fromarray(painted(index, rate, background)).save(data, "JPEG")
                    body = data.getvalue()
                    head = f"--b\r\nContent-Type: image/jpeg\r\nContent-Length: {len(body)}\r\n\r\n"
                    owner.sent.append(moment)
                    try:
                        self.wfile.write(head.encode() + body + b"\r\n")
                    except OSError:
                        return

            def log_message(self, *_: Any) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/"
        threading.Thread(target=self._server.serve_forever, daemon=True).start()


def measured(rate: float, seconds: float, more: list[str]) -> tuple[list[float], str]:
    """Run `motes watch`; return the ages of rows, and its summary."""
    camera = Camera(rate)
    rows: list[float] = []
    command = [sys.executable, "-m", "motes", "watch", camera.url, "-o", "-", *more]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        since, last = time.monotonic() + WARM_UP, -1
        end = since + seconds
        for row in process.stdout:
            now, name = time.monotonic(), row.partition(",")[0]
            if int(name) != last and now > since:
                last = int(name)
                rows.append(now - camera.sent[last])
            if now > end:
                break
        process.send_signal(signal.SIGINT)
        process.stdout.close()
        summary = process.stderr.read().strip().splitlines()[0]
    return rows, summary


def quantiles(ages: list[float]) -> list[Cell]:
    """Return the median of ages and their quantile of 95 %, in milliseconds."""
    if not ages:
        return [Cell(NO_VALUE)] * 2
    return [number(value, 0) for value in (1000 * np.quantile(ages, [0.5, 0.95])).tolist()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rates", nargs="+", type=float, help="pictures a second")
    parser.add_argument("--seconds", type=float, default=20.0)
    options, more = parser.parse_known_args()
    lines: list[Row] = []
    for rate in options.rates:
        rows, summary = measured(rate, options.seconds, more)
        print(summary, file=sys.stderr)
        lines.append((Cell(f"{rate:g}"), Cell(f"{len(rows)}"), *quantiles(rows)))
    head = ("pictures a second", "rows timed", "rows, median ms", "95 % below")
    print(markdown.table(Table("How old results are", head, lines)))


if __name__ == "__main__":
    main()
