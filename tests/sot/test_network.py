"""Trained networks: files, regions, boxes and scores, on networks that a test makes."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("onnx", reason="onnx is not installed")
pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")

import onnx_trackers
from motes import Box, ConfigError, Ellipse, Frame, SourceError
from motes.sot.network.network import Network
from motes.sot.network.view import Choice, NetworkView, Square, mean_color, read
from motes.sot.network.vit import DEVIATION, MEAN

RED, GRAY = (210, 40, 30), (90, 90, 90)
TARGET = Box(150, 100, 40, 60)


def picture(x: int, y: int, width: int = 40, height: int = 60) -> Frame:
    """Return a gray frame of 320x240 with a red target."""
    pixels = np.full((240, 320, 3), GRAY, np.uint8)
    pixels[max(y, 0) : y + height, max(x, 0) : x + width] = RED
    return Frame(0, 0.0, pixels)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("networks")


@pytest.fixture(params=["siamese", "vit"])
def network(request: pytest.FixtureRequest, folder: Path) -> Network:
    if request.param == "vit":
        return Network((onnx_trackers.save_vit(folder),))
    return Network(onnx_trackers.save_pair(folder))


def family(network: Network) -> str:
    return "vit" if len(network.files) == 1 else "siamese"


def resized(frame: Frame, region: Square, size: int, fill: Any) -> NDArray[np.uint8]:
    """Return what OpenCV makes of a region, whose part outside of the frame is filled."""
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    left, top, side = region
    padded = np.empty((side, side, 3), np.uint8)
    padded[:] = fill
    rows, columns = np.arange(top, top + side), np.arange(left, left + side)
    inside = ((rows >= 0) & (rows < frame.height), (columns >= 0) & (columns < frame.width))
    padded[np.ix_(*inside)] = frame.pixels[np.ix_(rows[inside[0]], columns[inside[1]])]
    out: NDArray[np.uint8] = cv2.resize(padded, (size, size)).transpose(2, 0, 1)
    return out


REGIONS = [
    (10, 20, 100), (-30, -40, 150), (250, 200, 127), (-500, -500, 60), (-300, -300, 1000),
    *((20, 10, side) for side in (1, 2, 3, 31, 64, 129, 200, 254, 255, 256, 300, 511, 760)),
]  # fmt: skip


@pytest.mark.parametrize("region", REGIONS, ids=str)
@pytest.mark.parametrize("form", ["rgb", "bgr", "gray", "part"])
def test_a_region_is_that_of_opencv_to_the_bit(region: Any, form: str) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (240, 320, 3), np.uint8)
    views = {
        "rgb": pixels,
        "bgr": np.ascontiguousarray(pixels[:, :, ::-1])[:, :, ::-1],
        "gray": np.broadcast_to(pixels[:, :, :1], pixels.shape),
        "part": np.dstack([pixels, pixels])[:, :, :3],
    }
    frame = Frame(0, 0.0, views[form])
    fill = mean_color(frame)
    np.testing.assert_allclose(fill, frame.pixels.mean((0, 1)))
    for size in (127, 255):
        out = read(frame, Square(*region), size, fill)
        assert out.shape == (1, 3, size, size)
        assert out.dtype == np.float32
        wanted = resized(frame, Square(*region), size, np.rint(fill))
        np.testing.assert_array_equal(out[0], wanted)


def test_the_family_is_read_from_the_files_in_any_order(folder: Path) -> None:
    backbone, head = onnx_trackers.save_pair(folder)
    assert Network((backbone, head)).open() == Network((head, backbone)).open() == "siamese"
    assert Network((onnx_trackers.save_vit(folder),)).open() == "vit"


@pytest.mark.parametrize("at", [(163, 95), (-12, 4), (290, 190)])
def test_views_are_decoded_as_numpy_does(network: Network, at: tuple[int, int]) -> None:
    """The networks are simple enough to be computed here, from the pixels on."""
    frame, place = picture(*at), Ellipse(at[0] + 17.3, at[1] + 26.8, 22, 31, 0.0)
    template = network.learn(picture(150, 100), Ellipse.from_box(TARGET))
    view = network.look(template, frame, place)
    width, height = 44.0, 62.0
    if family(network) == "siamese":
        learned = math.sqrt((40 + 50) * (60 + 50))
        side = round(math.sqrt((width + 53) * (height + 53)) * 255 / 127)
        fills, sizes = (mean_color(picture(150, 100)), mean_color(frame)), (127, 255)
    else:
        learned, side = 2 * math.sqrt(40 * 60), round(4 * math.sqrt(width * height))
        fills, sizes = (np.zeros(3), np.zeros(3)), (128, 256)
    first = Square.around(169.5, 129.5, learned)
    left, top = (round(center - (side - 1) / 2) for center in place[:2])
    template = read(picture(150, 100), first, sizes[0], fills[0])[0]
    search = read(frame, Square(left, top, side), sizes[1], fills[1])[0]
    row, column = np.mgrid[:16, :16]
    if family(network) == "siamese":
        by_side = onnx_trackers.DISTANCES * [[[-1]], [[-1]], [[1]], [[1]]]
        middle = np.stack([(column - 8) * 16 + 127.5, (row - 8) * 16 + 127.5] * 2)
        sides = (middle + by_side) * side / 255
    else:
        template, search = ((each[::-1] - MEAN) / DEVIATION for each in (template, search))
        middle = (np.stack([column, row]) + onnx_trackers.OFFSETS) * side / 16
        half = onnx_trackers.SIZES * side / 2
        sides = np.concatenate([middle - half, middle + half])
    share, sharp = 1.0, onnx_trackers.SHARP_VIT
    if family(network) == "siamese":
        share, sharp = 1 / 255, onnx_trackers.SHARP
    cells = [onnx_trackers.mean_colors(each) * share for each in (template, search)]
    wanted = onnx_trackers.scores(cells[0], cells[1], sharp).ravel()
    np.testing.assert_allclose(view.scores, wanted, atol=1e-4)
    assert view.scores.max() > 0.95 > 0.01 > view.scores.min()
    assert view.window.shape == view.scores.shape
    assert (view.size[0], view.size[1]) == pytest.approx((width, height))
    corner = np.array([left, top])[:, None, None]
    boxes = np.concatenate([sides[:2] + corner, sides[2:] - sides[:2]])
    np.testing.assert_allclose(view.boxes, boxes.reshape(4, -1).T, atol=1e-3)


def made_view(choice: Choice) -> NetworkView:
    rng = np.random.default_rng(3)
    corners, sizes = rng.uniform(0, 100, (256, 2)), rng.uniform(5, 60, (256, 2))
    hann = np.outer(np.hanning(16), np.hanning(16)).ravel()
    scores = rng.uniform(0, 1, 256) ** 4
    return NetworkView(np.hstack([corners, sizes]), scores, hann, (30.0, 20.0), choice)


@pytest.mark.parametrize(
    "choice",
    [Choice(), Choice(window=0.2, penalty=0.3, rate=0.9), Choice(window=1, multiplied=True)],
)
def test_the_choice_is_that_of_siamese_trackers(choice: Choice) -> None:
    view, ranks, kept = made_view(choice), [], []
    for (_, _, w, h), score, window in zip(view.boxes, view.scores, view.window, strict=True):
        extent, own = ((w + h) / 2 + w) * ((w + h) / 2 + h), (25 + 30) * (25 + 20)
        scale, shape = math.sqrt(extent / own), (30 / 20) / (w / h)
        penalty = math.exp(-(max(scale, 1 / scale) * max(shape, 1 / shape) - 1) * choice.penalty)
        mixed = (1 - choice.window) * penalty * score + choice.window * window
        ranks.append(penalty * score * window if choice.multiplied else mixed)
        kept.append(penalty)
    (box, best), row = view.best(), int(np.argmax(ranks))
    assert best == view.scores[row]
    x, y, w, h = view.boxes[row]
    rate = choice.rate * kept[row] * best
    assert box.width == pytest.approx(30 + rate * (w - 30))
    assert box.height == pytest.approx(20 + rate * (h - 20))
    assert box.x + box.width / 2 == pytest.approx(x + w / 2)
    assert box.y + box.height / 2 == pytest.approx(y + h / 2)
    _, alone = made_view(Choice(window=0, penalty=0)).best()
    assert alone == view.scores.max()


def test_other_files_are_refused_with_what_is_known(folder: Path, tmp_path: Path) -> None:
    backbone, head = onnx_trackers.save_pair(folder)
    vit = onnx_trackers.save_vit(folder)
    for files in ((backbone,), (head,), (backbone, backbone), (backbone, vit), (vit, vit)):
        with pytest.raises(ConfigError) as caught:
            Network(files).open()
        text = str(caught.value)
        assert "Known are siamese: NanoTrack's two" in text
        assert "vit: ViTTrack's one" in text
        assert all(Path(file).name in text for file in files)
        assert "\n" not in text
    three = onnx_trackers.save_pair(tmp_path, channels=3)
    with pytest.raises(ConfigError, match="no known kind"):
        Network(three).open()


def test_outputs_of_other_shapes_are_found_when_it_is_opened(tmp_path: Path) -> None:
    """The file leaves open how many distances its head gives, and there are three."""
    import onnx

    backbone, head = onnx_trackers.save_pair(tmp_path, channels=3)
    model = onnx.load(head)
    model.graph.node[-1].output[0] = "three"
    all_of_them = onnx.numpy_helper.from_array(np.ones(3, bool), "all")
    model.graph.initializer.append(all_of_them)
    chosen = onnx.helper.make_node("Compress", ["three", "all"], ["output2"], axis=1)
    model.graph.node.append(chosen)
    model.graph.output[1].type.tensor_type.shape.dim[1].dim_param = "open"
    onnx.save(model, head)
    with pytest.raises(SourceError, match="not the siamese network that they seem") as caught:
        Network((backbone, head)).open()
    assert "\n" not in str(caught.value)
