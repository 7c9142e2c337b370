"""Pictures of a run that goes on: in a window, or in a browser on this computer.

A picture is offered as a function that draws it. The function is called only while a viewer is
connected. A slow viewer misses pictures; the run never waits.
"""

from __future__ import annotations

import io
import os
import sys
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler
from typing import Any, Protocol

import numpy as np

from motes_fleet.delivery.local_server import Server, reply

Draw = Callable[[], np.ndarray]
"""Draws a picture, RGB, when it is called."""
TITLE = "motes"
QUALITY = 80
"""Quality of the JPEGs, as in Pillow."""
FASTEST = 1 / 30
"""Least seconds between two pictures for one browser."""
_PAGE = b"""<!doctype html><title>motes</title>
<style>body{margin:0;background:#222}img{display:block;max-width:100%;margin:auto}</style>
<img src="/stream" alt="live picture">
"""


class View(Protocol):
    """Where live pictures are shown."""

    @property
    def address(self) -> str | None:
        """The address of the page; None for a window."""

    def offer(self, draw: Draw) -> None:
        """Show a picture, or leave it out."""

    def close(self) -> None:
        """Show no more pictures."""


def view() -> View:
    """Return a window if OpenCV can open one on this screen, else a page on this computer."""
    # OpenCV ends the whole program if it finds no screen, so that must be asked before.
    if sys.platform in ("win32", "darwin") or "DISPLAY" in os.environ:
        try:
            return PictureWindow()
        except ImportError:
            pass
    return Page()


class PictureWindow:
    """A window of OpenCV; raise an ImportError if OpenCV is missing, or cannot open one."""

    address = None

    def __init__(self) -> None:
        import cv2

        self._cv2: Any = cv2
        self._shown = 0.0
        try:
            cv2.namedWindow(TITLE, cv2.WINDOW_NORMAL)
        except cv2.error as error:
            raise ImportError("OpenCV has no windows here") from error

    def offer(self, draw: Draw) -> None:
        """Show a picture, unless the last one is very new."""
        if time.monotonic() - self._shown < FASTEST:
            return
        self._shown = time.monotonic()
        self._cv2.imshow(TITLE, np.ascontiguousarray(draw()[:, :, ::-1]))
        self._cv2.waitKey(1)  # lets the window draw

    def close(self) -> None:
        """Close the window."""
        self._cv2.destroyAllWindows()


class Page:
    """A page with the newest picture, as a stream of JPEGs that any browser shows."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._drawing = threading.Lock()
        self._draw: Draw | None = None
        self._version = 0
        self._encoded, self._jpeg = 0, b""
        self._closed = False
        self._server = Server("127.0.0.1", 0, self._answer).start()
        self.address = self._server.address

    def offer(self, draw: Draw) -> None:
        """Make a picture the newest one."""
        with self._changed:
            self._draw, self._version = draw, self._version + 1
            self._changed.notify_all()

    def close(self) -> None:
        """Stop serving."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._server.close()

    def _answer(self, request: BaseHTTPRequestHandler) -> None:
        if request.path == "/stream":
            self._stream(request)
        elif request.path == "/":
            reply(request, "text/html; charset=utf-8", _PAGE)
        else:
            reply(request, "text/plain", b"There is no such page.\n", 404)

    def _stream(self, request: BaseHTTPRequestHandler) -> None:
        """Send the newest picture again and again, until the reader or the run ends."""
        request.send_response(200)
        request.send_header("Content-Type", "multipart/x-mixed-replace; boundary=picture")
        request.send_header("Cache-Control", "no-store")
        request.end_headers()
        sent = 0
        while True:
            with self._changed:
                while not self._closed and self._version == sent:
                    self._changed.wait()
                if self._closed:
                    return
            began = time.monotonic()
            sent, jpeg = self._newest()
            head = f"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
            request.wfile.write(head.encode() + jpeg + b"\r\n")
            time.sleep(max(0.0, began + FASTEST - time.monotonic()))

    def _newest(self) -> tuple[int, bytes]:
        """Return the newest picture and its number; all readers share it."""
        from PIL import Image

        with self._drawing:
            with self._changed:
                draw, version = self._draw, self._version
            if version != self._encoded and draw is not None:
                data = io.BytesIO()
                Image.fromarray(np.ascontiguousarray(draw())).save(data, "JPEG", quality=QUALITY)
                self._encoded, self._jpeg = version, data.getvalue()
            return self._encoded, self._jpeg
