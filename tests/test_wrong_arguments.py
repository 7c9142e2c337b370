"""Arguments that users confuse: one line says what is wanted, in motes' own words."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motes
from motes.core.geometry import Ellipse

PIXELS = np.random.default_rng(0).integers(0, 255, (72, 96, 3), np.uint8)
BOX = (20, 20, 20, 20)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    with motes.VideoWriter(path, fps=25) as writer:
        for frame, _ in motes.synthetic.still((96, 72), target=(20, 20), frames=4):
            writer.write(frame.pixels)
    return path


def writing(path: Path, *, fps: Any = 25, pixels: Any = PIXELS, time: Any = None) -> None:
    with motes.VideoWriter(path.with_name("new.mp4"), fps, overwrite=True) as writer:
        writer.write(pixels, time)


def pillow(mode: str) -> Any:
    from PIL import Image

    return Image.fromarray(PIXELS).convert(mode)


def started() -> motes.Tracker:
    tracker = motes.Tracker("nummiaro")
    tracker.init(PIXELS, BOX)
    return tracker


def several() -> motes.Trackers:
    trackers = motes.Trackers("nummiaro")
    trackers.init(PIXELS, [BOX])
    return trackers


def track() -> motes.Track:
    return motes.Track.nowhere(0, 0.0)


def trailing(*places: Any) -> None:
    motes.draw_scene(PIXELS, [started().info.track], {1: places})


def rows(film: Path, *what: Any) -> None:
    writer = motes.TrackWriter(str(film.with_name("rows.csv")), overwrite=True)
    writer.close()
    writer.write(*what)


def known() -> motes.KnownTarget:
    color = motes.cues.Color()
    return motes.KnownTarget.learn(color, motes.Frame(0, 0.0, PIXELS), BOX)  # type: ignore[arg-type]


def found(score: Any, label: Any) -> object:
    return motes.as_detections([motes.Detection(motes.Box(*BOX), score, label)])


def closed(film: Path) -> motes.VideoWriter:
    with motes.VideoWriter(film.with_name("closed.mp4"), fps=25, overwrite=True) as writer:
        writer.write(PIXELS)
    return writer


LINE = motes.Line((0, 0, 9, 9))


def counter() -> motes.EventCounter:
    return motes.EventCounter(motes.Regions(line=(LINE,)), (96, 72))


def watched(frames: Any) -> object:
    return list(motes.Scene(lambda frame: []).watch(frames))


CALLS: dict[str, tuple[Callable[[Any], object], str]] = {
    "keyframes in a list": (lambda film: motes.correct(film, [BOX]), "mapping"),  # type: ignore[arg-type]
    "keys as text": (lambda film: motes.correct(film, {"0": BOX}), "number of its frame"),  # type: ignore[dict-item]
    "a rate as text": (lambda film: writing(film, fps="x"), "frames per second"),
    "no picture to write": (lambda film: writing(film, pixels=None), "picture"),
    "a time of NaN": (lambda film: writing(film, time=float("nan")), "seconds"),
    "one line": (lambda _: motes.EventCounter(motes.Line((0, 0, 9, 9))), "Regions"),  # type: ignore[arg-type]
    "no track": (lambda _: motes.draw(PIXELS, None), "Draw a Track"),  # type: ignore[arg-type]
    "a set": (lambda _: motes.Tracker().init(PIXELS, {20, 21, 22, 23}), "region is"),  # type: ignore[arg-type]
    "bytes": (lambda _: motes.Tracker().init(PIXELS, b"2222"), "region is"),
    "a picture as a region": (
        lambda _: motes.Tracker().init(PIXELS, PIXELS.tolist()),
        "region is .{,120}$",
    ),
    "digits": (lambda _: motes.Tracker().init(PIXELS, "9999"), "region is"),  # type: ignore[arg-type]
    "a row of bytes": (lambda _: motes.as_detections([b"2222"]), "must return"),
    "a box in a set": (lambda _: motes.as_detections([motes.Detection({1, 2, 3, 4})]), "must"),  # type: ignore[arg-type]
    "no scene": (lambda _: motes.Scene(lambda frame: [], {}), "scene_config"),  # type: ignore[arg-type]
    "the frame beside a region": (lambda _: several().add(PIXELS, BOX), "region alone"),  # type: ignore[arg-type]
    "the frame of a correction": (lambda _: started().correct(PIXELS, BOX), "region alone"),  # type: ignore[arg-type]
    "one region": (lambda _: motes.Trackers().init(PIXELS, BOX), "list of regions"),  # type: ignore[arg-type]
    "an object between two": (lambda _: several().remove(0.0), "no object"),  # type: ignore[arg-type]
    "what OpenCV reads": (lambda _: motes.Tracker().init((True, PIXELS), BOX), "got tuple"),  # type: ignore[arg-type]
    "a palette": (lambda _: motes.Tracker().init(pillow("P"), BOX), "convert"),
    "four inks": (lambda _: motes.Tracker().init(pillow("CMYK"), BOX), "convert"),
    "no detector": (lambda _: motes.Tracker().detect(PIXELS, "people"), "callable"),  # type: ignore[arg-type]
    "no known target": (lambda _: motes.Tracker("nummiaro").search(PIXELS, BOX), "KnownTarget"),  # type: ignore[arg-type]
    "a network's number": (lambda _: motes.Tracker(network=3), "give files"),  # type: ignore[arg-type]
    "no place": (lambda _: motes.Tracker("nummiaro").search(PIXELS, known(), [BOX]), "Places"),  # type: ignore[list-item]
    "a score of None": (lambda _: found(None, None), "must return"),
    "a class of bytes": (lambda _: found(0.5, b"car"), "must return"),
    "a film too large": (
        lambda film: writing(film, pixels=np.zeros((20000, 20000, 3), np.uint8)),
        "cannot be written",
    ),
    "a picture after the end": (lambda film: closed(film).write(PIXELS), "is closed"),
    "no preset": (lambda _: motes.preset(None), "No preset"),  # type: ignore[arg-type]
    "changes alone": (lambda _: motes.configure({"particles": 3}), "preset's name"),  # type: ignore[arg-type]
    "changes as text": (lambda _: motes.configure("nummiaro", "particles=3"), "changes"),  # type: ignore[arg-type]
    "no file to save": (lambda _: started().save(None), "name of a file"),  # type: ignore[arg-type]
    "no file to load": (lambda _: motes.Tracker.load(None), "name of a file"),  # type: ignore[arg-type]
    "no file of keyframes": (lambda _: motes.read_keyframes(None), "name of a file"),  # type: ignore[arg-type]
    "no file of rows": (lambda _: motes.read_track(None), "name of a file"),  # type: ignore[call-overload]
    "no file for rows": (lambda _: motes.TrackWriter(None), "name of a file"),  # type: ignore[arg-type]
    "no film to write": (lambda _: motes.VideoWriter(None, 25), "name of a file"),  # type: ignore[arg-type]
    "pictures as a source": (lambda _: motes.open_source(PIXELS), "name of a file"),  # type: ignore[arg-type]
    "a picture as index": (lambda _: motes.Frame(PIXELS, 1, 0.04), "number, no ndarray"),  # type: ignore[arg-type]
    "a frame to write": (lambda film: writing(film, pixels=motes.Frame(0, 0, PIXELS)), "pixels"),
    "a frame to draw on": (lambda _: motes.draw(motes.Frame(0, 0, PIXELS), track()), "got Frame"),  # type: ignore[arg-type]
    "a track without its frame": (lambda film: rows(film, track(), 0, 0), "frame's index"),
    "the tracks of a scene": (lambda film: rows(film, 0, 0, [track()]), "frame's index"),
    "rows after the end": (lambda film: rows(film, 0, 0, None), "is closed"),
    "one track of a scene": (lambda _: motes.draw_scene(PIXELS, track(), {}), "list of Tracks"),  # type: ignore[arg-type]
    "boxes as tracks": (lambda _: motes.draw_scene(PIXELS, [BOX]), "list of Tracks"),  # type: ignore[list-item]
    "boxes as a trail": (lambda _: trailing(BOX), "places x, y"),
    "ellipses as a trail": (lambda _: trailing((1, 2, 3, 4, 0.5)), "places x, y"),
    "an open film": (lambda film: motes.correct(motes.open_source(film), {0: BOX}), "of a file"),  # type: ignore[arg-type]
    "trails in a list": (lambda _: motes.draw_scene(PIXELS, [], []), "mapping"),  # type: ignore[arg-type]
    "one line to draw": (lambda _: motes.draw_scene(PIXELS, [], {}, LINE), "as Regions"),  # type: ignore[arg-type]
    "boxes to count": (lambda _: counter().update([BOX]), "list of Tracks"),  # type: ignore[list-item]
    "a time as text": (lambda _: counter().update([], "0"), "in seconds"),  # type: ignore[arg-type]
    "a width to count in": (lambda _: motes.EventCounter(None, 640), "width and height"),  # type: ignore[arg-type]
    "a name to watch": (lambda film: watched(str(film)), "frames of a film"),
    "one picture to watch": (lambda _: watched(PIXELS), "frames of a film.* one picture"),
    "one frame to watch": (lambda _: watched(motes.Frame(0, 0, PIXELS)), "frames of a film"),
    "one gray picture to prepare": (
        lambda _: motes.Scene(motes.named_detector()).prepare(PIXELS[:, :, 0]),
        "one picture",
    ),
    "nothing to prepare": (lambda _: motes.Scene(motes.named_detector()).prepare(None), "film"),  # type: ignore[arg-type]
    "nothing to smooth": (lambda _: motes.smooth(None), "Give the Track"),  # type: ignore[arg-type]
    "tracks one by one": (lambda _: motes.smooth(iter([track()])), "Give the Track"),  # type: ignore[arg-type]
    "a width and a height": (lambda _: motes.synthetic.growing(320, 240), "two numbers"),  # type: ignore[arg-type]
    "a rate of a source as text": (lambda film: motes.open_source(film, fps="7"), "fps is '7'"),  # type: ignore[arg-type]
    "a row between two frames": (lambda film: rows(film, 1.5, 0, None), "frame's index"),
    "a row before the first frame": (lambda film: rows(film, -1, 0, None), "frame's index"),
    "a row at no time": (lambda film: rows(film, 0, float("nan"), None), "its time"),
    "no time to count": (lambda _: counter().update([], float("nan")), "in seconds"),
    "a width of half a pixel": (lambda _: motes.synthetic.growing((100.5, 100)), "two numbers"),  # type: ignore[arg-type]
    "a number as a cue": (
        lambda _: motes.ParticleFilter(color=motes.cues.Color(), extra_cues={"hue": 3}),  # type: ignore[dict-item]
        "got 3; it takes a Cue",
    ),
    "smoothed twice": (lambda film: motes.smooth(motes.correct(film, {0: BOX})), "already"),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_argument_is_named(name: str, film: Path) -> None:
    call, said = CALLS[name]
    with pytest.raises(motes.MotesError, match=said):
        call(film)


def test_smoothed_tracks_are_refused_and_those_of_a_tracker_taken() -> None:
    tracker = motes.Tracker("nummiaro")
    tracks = [tracker.init(PIXELS, BOX), *(tracker.update(PIXELS) for _ in range(3))]
    smooth = motes.smooth(tracks)
    with pytest.raises(motes.ConfigError, match="already"):
        motes.smooth(smooth)


def test_numbers_of_numpy_and_fractions_of_pyav_are_rates_and_times(film: Path) -> None:
    with motes.open_source(film, start=np.int64(1), fps=np.float32(10)) as frames:  # type: ignore[arg-type]
        found = [(each.index, each.time) for each in frames]
    assert found == [(1, 0.1), (2, 0.2), (3, 0.3)]
    assert all(type(number) in (int, float) for pair in found for number in pair)
    ntsc = Fraction(30000, 1001)
    writing(film, fps=ntsc, time=3 / ntsc)
    assert motes.Frame(0, 3 / ntsc, PIXELS).time == pytest.approx(0.1001)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [(np.nan, 5, 20, 20), (5, 5, -20, 20), (5, 5, 20, np.inf)])
def test_what_is_no_box_is_said(wrong: Any) -> None:
    scene = motes.Scene(lambda frame: [wrong, (40, 20, 20, 20)] if frame.index == 1 else [])
    for _ in range(3):
        scene.update(PIXELS)
    assert scene.warnings == {
        "broken": "Frame 1: detections with NaN, infinity or no size are left out, 1 here."
    }


def test_a_network_learns_of_an_image_and_a_tuple(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    from motes.sot.network.network import Network
    from onnx_trackers import save_pair

    network = Network(tuple(map(str, save_pair(tmp_path))))
    one = network.learn(motes.Frame(0, 0.0, PIXELS), Ellipse(30, 30, 10, 10))
    other = network.learn(PIXELS, (30, 30, 10, 10, 0))  # type: ignore[arg-type]
    np.testing.assert_array_equal(one, other)
    with pytest.raises(motes.SourceError, match="no picture"):
        network.learn(None, BOX)  # type: ignore[arg-type]


def test_tracks_of_a_scene_may_be_those_of_a_mapping() -> None:
    tracks: Any = {1: started().info.track}.values()
    assert motes.draw_scene(PIXELS, tracks).shape == PIXELS.shape


def test_numbers_and_classes_of_detections_may_have_any_type() -> None:
    assert motes.as_detections([motes.Detection(motes.Box(*BOX), np.float32(0.5), 2)]) == [  # type: ignore[arg-type]
        motes.Detection(motes.Box(*BOX), 0.5, "2")
    ]
