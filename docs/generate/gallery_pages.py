"""Make the pictures that pages open with, where the gallery has none: docs/images/pages."""

from __future__ import annotations

import io
import socket
import sys
import tempfile
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import chdir
from importlib import import_module
from itertools import islice
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from gallery_commands import moments, printed, side_by_side, terminal
from motes import Box, Ellipse, Track, Tracker, VideoWriter, read_track, synthetic
from motes.core.types import Bytes, Floats
from motes.cues.color import Color
from motes.output.motion_charts import MotionSeries, path, speed, style
from motes.output.overlay import draw, font
from motes.output.scene_overlay import draw_scene
from motes_fleet.services import cvat_agent
from pages import blocks

DOCS = Path(__file__).resolve().parents[1]
OUT = DOCS / "images/pages"
HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n"
PART = b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n"
GLOW = np.array((255, 120, 0))
"""The color of what a mask or a map shows."""
HIGH = 300
"""Height of a picture."""
CAMERA = "http://camera/stream"
"""What stands for the address of the camera of this machine."""
RIG = """
[[camera]]
name = "west"
source = "west.mp4"
[[camera]]
name = "east"
source = "east.mp4"
[[overlap]]
cameras = ["west", "east"]
homography = [[1.0, 0.0, {shift}], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
"""


def made(page: str, count: int) -> dict[str, Any]:
    """Run the first pieces of Python of a page, and write its modules; return the names."""
    names: dict[str, Any] = {}
    python = [block for block in blocks(DOCS / page) if block.language == "python"]
    for block in python[:count]:
        if block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        else:
            exec(compile(block.text, page, "exec"), names)
    return names


def write(path: str, frames: Iterable[Bytes], fps: float = 25) -> None:
    """Write a film."""
    with VideoWriter(path, fps) as writer:
        for pixels in frames:
            writer.write(pixels)


def worded(pixels: Bytes, words: str) -> Bytes:
    """Return a picture with words in its upper left corner."""
    image = Image.fromarray(pixels)
    place, size = (6, 4), max(12, image.height // 17)
    ImageDraw.Draw(image).text(
        place, words, "white", font(size), stroke_width=2, stroke_fill="black"
    )
    return np.array(image)


def glowing(pixels: Bytes, share: Floats) -> Bytes:
    """Return a gray picture that glows by a share (height, width) from 0 to 1."""
    gray = 0.6 * pixels.mean(axis=2, keepdims=True).repeat(3, axis=2)
    out: Bytes = ((1 - share[..., None]) * gray + share[..., None] * GLOW).astype(np.uint8)
    return out


def below(pixels: Bytes, lines: Iterable[str]) -> Bytes:
    """Return a picture with lines of text below it."""
    rows = [part for line in lines for part in textwrap.wrap(line, 64, subsequent_indent="    ")]
    image = Image.new("RGB", (pixels.shape[1], pixels.shape[0] + 20 * len(rows) + 12), "#1d2430")
    image.paste(Image.fromarray(pixels))
    pen = ImageDraw.Draw(image)
    for number, row in enumerate(rows):
        pen.text((10, pixels.shape[0] + 6 + 20 * number), row, "#e4e8ee", font(14))
    return np.array(image)


def count() -> Bytes:
    """Return people who cross a line, and how many have done so."""
    made("tutorials/count.md", 1)
    printed("motes watch hall.mp4 --line 160,240,160,0 -o hall.csv --overlay seen.mp4", Path.cwd())
    return side_by_side(moments(Path("seen.mp4"), (92, 150)), HIGH)


def detector() -> Bytes:
    """Return the mask of blue shirts in a frame, and the people who are followed."""
    made("tutorials/detector.md", 2)
    printed(
        "motes watch team.mp4 --detector shirts:blue -o shirts.csv --overlay seen.mp4", Path.cwd()
    )
    (pixels,) = moments(Path("team.mp4"), (45,))
    red, green, blue = np.moveaxis(pixels.astype(int), -1, 0)
    mask = ((blue > red + 25) & (blue > green + 15)).astype(float)
    (seen,) = moments(Path("seen.mp4"), (45,))
    return side_by_side([worded(glowing(pixels, mask), "blue pixels"), seen], HIGH)


def measure() -> Bytes:
    """Return a ball with its speed, and the figures of its path and speed."""
    made("tutorials/measure.md", 1)
    line = "motes track throw.mp4 --at 0=77,301,38,38 --scale 160 -o throw.csv --overlay seen.mp4"
    printed(line, Path.cwd())
    rows = read_track("throw.csv")
    series = MotionSeries(*(rows[name] for name in MEASURED))
    shown = [moments(Path("seen.mp4"), (22,))[0][:360, :420]]
    with style():
        for figure in (path(series, "m"), speed(series, "m")):
            file = io.BytesIO()
            figure.savefig(file, dpi=200)
            shown.append(np.array(Image.open(file).convert("RGB")))
    return side_by_side(shown, 240)


MEASURED = (
    *("time", "x_m", "y_m", "x_m_std", "y_m_std", "speed", "speed_std"),
    *("a", "b", "a_std", "b_std"),
)
"""Columns of a course in metres."""


def cameras() -> Bytes:
    """Return two views of a street at one moment, whose objects have the numbers of the rig."""
    film = [frame.pixels for frame, _ in synthetic.Street()]
    width = film[0].shape[1]
    wide = 5 * width // 8
    write("west.mp4", (pixels[:, :wide] for pixels in film))
    write("east.mp4", (pixels[:, width - wide :] for pixels in film))
    Path("rig.toml").write_text(RIG.format(shift=float(wide - width)))
    printed("motes watch rig.toml -o rows.csv", Path.cwd())
    rows, shown = read_track("rows.csv"), []
    for name in ("west", "east"):
        here = rows[(rows["camera"] == name) & (rows["frame"] == MOMENT)]
        objects = [
            Track(MOMENT, row["time"], Ellipse.from_box(box), identity=int(row["id"]), bounds=box)
            for row in here
            for box in [Box(*(float(row[side]) for side in ("left", "top", "width", "height")))]
        ]
        (pixels,) = moments(Path(f"{name}.mp4"), (MOMENT,))
        shown.append(draw_scene(pixels, objects, caption=name))
    return side_by_side(shown, HIGH)


MOMENT = 60
"""The frame in which both cameras see a car."""


def services() -> Bytes:
    """Return the rectangle that somebody draws, and those that the function gives back."""
    # Of the SDK of CVAT the function needs a class for its answers.
    sdk: Any = ModuleType("cvat_sdk.auto_annotation")
    sdk.TrackableShape = SimpleNamespace
    sys.modules |= {"cvat_sdk": ModuleType("cvat_sdk"), "cvat_sdk.auto_annotation": sdk}
    function, shown = cvat_agent.create(), []
    for frame, (truth, *_) in synthetic.demo((480, 360)):
        image = function.preprocess_image(None, Image.fromarray(frame.pixels))
        if not frame.index:
            shape = SimpleNamespace(points=cvat_agent.corners_of(truth.ellipse.box))
            state = function.init_tracking_state(None, image, shape)
        else:
            shape = function.track(None, image, state)
        if frame.index in (0, 45, 66):
            words = "drawn" if not frame.index else "followed" if shape else "no shape"
            picture = Image.fromarray(frame.pixels)
            if shape:
                ImageDraw.Draw(picture).rectangle(shape.points, outline="#ffe14d", width=2)
            part = np.array(picture.crop((0, 180, 240, 360)).resize((480, 360)))
            shown.append(worded(part, f"{frame.index}: {words}"))
    return side_by_side(shown, 240)


def extend() -> Bytes:
    """Return a target, and where its surroundings are like it by color and by hue alone."""
    made("extend.md", 1)
    sys.path.insert(0, "")
    hue = import_module("motes_hue").Hue(bins=12)
    frame, (truth, *_) = synthetic.Pitch()[48]
    rows, columns = np.mgrid[: frame.height : 3, : frame.width : 3]
    places = np.tile(np.array(truth.ellipse), (rows.size, 1))
    places[:, 0], places[:, 1] = columns.ravel(), rows.ravel()
    target = Tracker(seed=0).init(frame, truth.ellipse)
    shown = [(draw(frame.pixels, target, label=""), "target")]
    for cue, words in ((Color(), "color"), (hue, "hue, of the package")):
        far = cue.distances(cue.learn(frame, truth.ellipse), frame, places).reshape(rows.shape)
        share = np.exp(-(far**2) / (2 * 0.1**2)).astype(np.float32)  # as the default likelihood
        whole = Image.fromarray(share).resize((frame.width, frame.height))
        shown.append((glowing(frame.pixels, np.array(whole)), words))
    return side_by_side((worded(pixels[80:250, 80:306], words) for pixels, words in shown), HIGH)


def camera(*parts: int) -> str:
    """Start a camera on this machine that sends a street as JPEGs over HTTP; return its address.

    `parts` are numbers of frames: after each of them the camera is away until it is opened again.
    """
    server = socket.create_server(("127.0.0.1", 0))
    film = [jpeg(frame.pixels) for frame, _ in islice(synthetic.Street(), sum(parts))]

    def serve() -> None:
        coming = iter(film)
        for part in parts:
            connection, _ = server.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(HEAD)
                for picture in islice(coming, part):
                    connection.sendall(PART % len(picture) + picture + b"\r\n")
                    time.sleep(0.1)
        server.close()

    threading.Thread(target=serve, daemon=True).start()
    return f"http://127.0.0.1:{server.getsockname()[1]}/stream"


def jpeg(pixels: Bytes) -> bytes:
    """Return a picture as a camera sends it."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=95)
    return file.getvalue()


def watch_live() -> Bytes:
    """Return a moment of a street, and the last events before it."""
    write("street.mp4", (frame.pixels for frame, _ in islice(synthetic.Street(), 151)))
    more = "--line 150,130,150,235 --events events.jsonl --overlay seen.mp4"
    printed(f"motes watch street.mp4 {more}", Path.cwd())
    events = Path("events.jsonl").read_text().replace(',"', ', "').splitlines()
    events = [each for each in events if '"frame":150' not in each]  # those of the film's end
    (shown,) = moments(Path("seen.mp4"), (150,))
    return below(shown, events[-3:])


def sources() -> str:
    """Return what a film, images and a camera that is away for a moment print."""
    film = [frame.pixels for frame, _ in islice(synthetic.demo((320, 240)), 50)]
    write("film.mp4", film)
    Path("img").mkdir()
    for number, pixels in enumerate(film):
        Image.fromarray(pixels).save(f"img/{number:03}.png")
    lines = (
        "motes track film.mp4 --init 31,161,34,27 -o film.csv",
        "motes track 'img/*.png' --fps 7 --init 31,161,34,27 -o images.csv",
    )
    parts = [f"$ {line}\n{printed(line, Path.cwd())}" for line in lines]
    address, more = camera(60, 60), "-o camera.csv --reconnect 2"
    told = printed(f"motes watch {address} {more}", Path.cwd(), 7).replace(address, CAMERA)
    first, _, rest = "".join([*parts, f"$ motes watch {CAMERA} {more}\n{told}"]).partition("\n")
    return terminal(first[2:], rest)


PICTURES: Mapping[str, Callable[[], Bytes]] = {
    "count": count,
    "detector": detector,
    "measure": measure,
    "cameras": cameras,
    "services": services,
    "extend": extend,
    "watch-live": watch_live,
}


def main(names: Sequence[str]) -> None:
    """Make all pictures, or those with the given names."""
    OUT.mkdir(exist_ok=True)
    for name in names or (*PICTURES, "sources"):
        with tempfile.TemporaryDirectory() as folder, chdir(folder):
            if name == "sources":
                (OUT / "sources.svg").write_text(sources(), encoding="utf-8")
            else:
                picture = Image.fromarray(PICTURES[name]())
                picture.save(OUT / f"{name}.webp", quality=70, method=6)


if __name__ == "__main__":
    main(sys.argv[1:])
