"""What COCO, CVAT, Label Studio and YOLO write beside the usual: it is recognized, or refused."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from motes.core.errors import SourceError
from motes.formats import FilmFacts, Recording, registry

SIZE = {"width": 320, "height": 240}
FILM = FilmFacts(source="n.mp4", width=320, height=240, frames=60, fps=25.0)


def frames(found: Recording) -> list[int]:
    return [row.frame for row in found if row.objects]


def labeled(folder: Path, *tasks: dict[str, Any]) -> Path:
    path = folder / "a.ls.json"
    path.write_text(json.dumps([*tasks]))
    return path


def region(rate: float = 25.0, count: int = 60, turned: float = 0) -> dict[str, Any]:
    """Return an object that moves by 2.5 pixels in 1/25 s, as Label Studio writes it."""
    keys = [
        {
            "frame": frame, "time": frame / rate, "enabled": frame < count, "rotation": turned,
            "x": (20 + 62.5 * (frame - 1) / rate) / 3.2, "y": 25, "width": 10, "height": 10,
        }
        for frame in (1, count // 2, count)
    ]  # fmt: skip
    value = {"framesCount": count, "labels": ["car"], "sequence": keys}
    return {"type": "videorectangle", "value": value}


@pytest.mark.parametrize("form", ["coco", "cvat"])
def test_an_image_that_is_none_of_the_films_is_named(form: str, tmp_path: Path) -> None:
    film = FilmFacts(width=320, height=240, files=["a_1.png", "a_2.png"])
    path = (
        coco(tmp_path, ("a_1.png", "other.png"))
        if form == "coco"
        else cvat(tmp_path, "", images("a_1.png", "other.png"))
    )
    with pytest.raises(SourceError, match="image other: the film has no image of this name; give"):
        registry.read(path, form, film)


def test_a_task_that_stands_alone(tmp_path: Path) -> None:
    """As Label Studio's API gives it, without the list of an export."""
    path = labeled(tmp_path, {"id": 7, "annotations": [{"result": [region()]}]})
    path.write_text(path.read_text()[1:-1])
    assert registry.recognized(path) == "label-studio"
    assert frames(registry.read(path, "label-studio", FILM)) == [*range(60)]


@pytest.mark.parametrize(("rate", "count"), [(25.0, 60), (12.5, 30), (24.0, 58), (50.0, 120)])
def test_an_annotation_at_another_rate_is_mapped_by_time(
    rate: float, count: int, tmp_path: Path
) -> None:
    path = labeled(tmp_path, {"annotations": [{"result": [region(rate, count)]}]})
    found = registry.read(path, "label-studio", FILM)
    assert frames(found)[0] == 0
    assert len(frames(found)) >= 60 - 25 / rate
    for row in found:
        assert row.time == pytest.approx(row.frame / 25)
        assert row.objects[0].box.x == pytest.approx(20 + 2.5 * row.frame, abs=1.3)
    assert bool(found.notes) == (rate != 25)


@pytest.mark.parametrize("times", [(0.0, 2.36), (None, None)])
def test_times_that_are_of_no_rate_shift_nothing(
    times: tuple[float | None, float | None], tmp_path: Path
) -> None:
    drawn = region()
    drawn["value"]["sequence"] = [
        {**key, "time": time}
        for key, time in zip(drawn["value"]["sequence"][::2], times, strict=True)
    ]
    drawn["value"]["labels"].append("bus")
    path = labeled(tmp_path, {"annotations": [{"result": [drawn]}]})
    found = registry.read(path, "label-studio", FILM)
    assert frames(found) == [*range(60)]
    assert [row.time for row in found] == pytest.approx([each / 25 for each in range(60)])
    assert not found.notes
    assert found.left_out == ["further classes of 1 region"]


SEEN, CANCELLED = {"result": [region()]}, {"result": [], "was_cancelled": True}


@pytest.mark.parametrize(
    ("task", "ignored"),
    [
        ({"annotations": [SEEN, CANCELLED], "predictions": [17]}, 1),
        ({"annotations": [{"result": []}, SEEN | {"ground_truth": True}]}, 1),
        ({"annotations": [], "predictions": [17, {"model_version": "x", **SEEN}]}, 0),
    ],
)
def test_one_annotation_counts(task: dict[str, Any], ignored: int, tmp_path: Path) -> None:
    found = registry.read(labeled(tmp_path, task), "label-studio", FILM)
    assert len(frames(found)) == 60
    assert found.left_out == ["1 annotation, cancelled or beside the truth"] * ignored


def coco(folder: Path, names: Sequence[str | dict[str, Any]], **more: Any) -> Path:
    """Write a document with an object in each image; its class is 1."""
    given = [{"file_name": each} if isinstance(each, str) else each for each in names]
    images = [{"id": 7 + i, **SIZE, **each} for i, each in enumerate(given)]
    document = {
        "images": images,
        "categories": [{"id": 1, "name": "car"}],
        "annotations": [
            {"image_id": each["id"], "category_id": 1, "bbox": [30, 60, 40, 20], **more}
            for each in images
        ],
    }
    path = folder / "a.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("names", "files", "expected"),
    [
        (["frame_000010.PNG", "frame_000030.PNG"], (), [10, 30]),
        (["frame_000005.PNG", "frame_000010.PNG"], (), [5, 10]),
        (["000000.png", "000005.png"], (), [0, 5]),
        (["000001.jpg", "000002.jpg"], (), [0, 1]),
        (["c.jpg", "d.jpg"], (), [0, 1]),
        (["x/000005.png", "x/000015.png"], [f"{5 * i:06}.png" for i in range(4)], [1, 3]),
        (["a_png.rf.0f1e22.jpg", "c_png.rf.77.jpg"], ["a.png", "b.png", "c.png"], [0, 2]),
        ([r"x\3fe2aa12-a.png", r"x\9c12de01-c.png"], ["a.png", "b.png", "c.png"], [0, 2]),
        (["3fe2aa12-c.png", "9c12de01-d.png"], (), [0, 1]),
        ([{"frame_id": 1, "prev_image_id": -1}, {"frame_id": 2, "prev_image_id": 7}], (), [0, 1]),
        ([{"frame_id": 0}, {"frame_id": 3}], (), [0, 3]),
        ([{"frame_id": 1}, {"frame_id": 2}], (), [0, 1]),
        ([{"frame": 1}, {"frame": 2}], (), [1, 2]),
    ],
)
def test_frames_of_cocos_images(
    names: list[str | dict[str, Any]], files: Sequence[str], expected: list[int], tmp_path: Path
) -> None:
    facts = FilmFacts(source="film", width=320, height=240, files=files)
    assert frames(registry.read(coco(tmp_path, names), "coco", facts)) == expected


@pytest.mark.parametrize(("numbers", "said"), [((1, 2), "is frame 0"), ((1, 9), "from 0; if")])
@pytest.mark.parametrize(("key", "ending"), [("frame_id", ""), ("file_name", ".png")])
def test_how_frames_that_may_count_from_1_are_understood_is_said(
    numbers: Sequence[int], said: str, key: str, ending: str, tmp_path: Path
) -> None:
    given = [{key: f"{each}{ending}" if ending else each} for each in numbers]
    (note,) = registry.read(coco(tmp_path, given), "coco", FILM).notes
    assert said in note


def cvat(folder: Path, meta: str, content: str) -> Path:
    path = folder / "a.xml"
    path.write_text(f"<annotations><meta>{meta}</meta>{content}</annotations>")
    return path


TASK = (
    "<task><size>2</size>"
    "<original_size><width>320</width><height>240</height></original_size></task>"
)
BOX = '<box frame="0" keyframe="1" outside="0" occluded="0" xtl="30" ytl="60" xbr="70" ybr="80"{}/>'


def images(*names: str) -> str:
    shape = '<box label="car" occluded="0" xtl="30" ytl="60" xbr="70" ybr="80"/>'
    parts = (f'<image id="{i}" name="{name}">{shape}</image>' for i, name in enumerate(names))
    return "".join(parts)


@pytest.mark.parametrize(
    ("names", "files", "expected"),
    [
        (["i_010.png", "i_015.png"], [f"i_{5 * i:03}.png" for i in range(4)], [2, 3]),
        (["frame_000010.png", "frame_000020.png"], (), [10, 20]),
        (["i_1.png", "i_2.png"], (), [0, 1]),
        (["4f3e2a19.png", "77.png"], (), [0, 1]),
        (["9.png", "10.png"], ["9.png", "10.png"], [0, 1]),
    ],
)
def test_frames_of_cvats_images(
    names: list[str], files: Sequence[str], expected: list[int], tmp_path: Path
) -> None:
    facts = FilmFacts(source="film", width=320, height=240, files=files)
    found = registry.read(cvat(tmp_path, "", images(*names)), "cvat", facts)
    assert [row.frame for row in found] == expected
    assert bool(found.notes) == ("77.png" in names)


@pytest.mark.parametrize(
    ("meta", "expected"),
    [
        ("<task><size>3</size>{}</task>", [10, 20, 30]),
        ("<job><size>3</size>{}</job>", [20]),
        ("<task><size>3</size></task>", [0, 1, 2, 20]),
    ],
)
def test_frames_of_no_task_are_unknown(meta: str, expected: list[int], tmp_path: Path) -> None:
    step = "<start_frame>10</start_frame><frame_filter>step=10</frame_filter>"
    there = BOX.format("").replace('frame="0"', 'frame="20"')
    found = registry.read(cvat(tmp_path, meta.format(step), track(0, shape=there)), "cvat", FILM)
    assert [row.frame for row in found] == expected


@pytest.mark.parametrize("kind", ["task", "job"])
def test_frames_that_a_task_of_cvat_skips_are_not_interpolated(kind: str, tmp_path: Path) -> None:
    meta = f"<{kind}><size>4</size><start_frame>10</start_frame>"
    meta += f"<frame_filter>step=10</frame_filter></{kind}>"
    there = [BOX.format("").replace('frame="0"', f'frame="{frame}"') for frame in (10, 20, 40)]
    document = cvat(tmp_path, meta, track(0, shape="".join(there)))
    assert frames(registry.read(document, "cvat", FILM)) == [10, 20, 30, 40]


@pytest.mark.parametrize("text", [False, "False", "0", None, 0])
def test_marks_of_coco_may_be_text(text: Any, tmp_path: Path) -> None:
    path = coco(tmp_path, ["1.png"], attributes={"occluded": text}, iscrowd=text)
    (row,) = registry.read(path, "coco", FILM)
    assert row.objects[0].status == "tracking"
    path = coco(tmp_path, ["1.png"], iscrowd="true")
    assert registry.read(path, "coco", FILM).left_out == ["1 annotation of a crowd"]


def test_polygons_without_a_box_have_the_box_around_them(tmp_path: Path) -> None:
    polygons = [[10, 20, 30, 20, 30, 50], [5, 25, 8, 25, 8, 28]]
    path = coco(tmp_path, ["1.png"], bbox=None, segmentation=polygons)
    (row,) = registry.read(path, "coco", FILM)
    assert row.objects[0].box == pytest.approx((5, 20, 25, 30))


BONES = '<skeleton {}><points label="1" outside="0" occluded="0" points="1,2"/></skeleton>'


def track(number: int, task: int | None = None, shape: str = BOX.format("")) -> str:
    of = "" if task is None else f' task_id="{task}"'
    return f'<track id="{number}" label="car"{of}>{shape}</track>'


SQUARE = '<box frame="{}" xtl="{}" ytl="90" xbr="{}" ybr="110" rotation="45"/>'


def of_cvat(folder: Path) -> Recording:
    shapes = SQUARE.format(0, 180, 220) + SQUARE.format(2, 184, 224)
    return registry.read(cvat(folder, TASK, track(0, shape=shapes)), "cvat", FILM)


def of_coco(folder: Path) -> Recording:
    path = coco(folder, ["frame_000000.png"], bbox=[180, 90, 40, 20], attributes={"rotation": 45.0})
    return registry.read(path, "coco", FILM)


def of_label_studio(folder: Path) -> Recording:
    left, top, root = 200 - 10 * 2**0.5 / 2, 100 - 30 * 2**0.5 / 2, region(turned=45)
    for key in root["value"]["sequence"]:
        key |= {"x": left / 3.2, "y": top / 2.4, "width": 40 / 3.2, "height": 20 / 2.4}
    return registry.read(
        labeled(folder, {"annotations": [{"result": [root]}]}), "label-studio", FILM
    )


def of_vot(folder: Path) -> Recording:
    path = folder / "groundtruth.txt"
    path.write_text("192.929,78.787,221.213,107.071,207.071,121.213,178.787,92.929\n")
    return registry.read(path, "vot", FILM)


@pytest.mark.parametrize("made", [of_cvat, of_coco, of_label_studio, of_vot])
def test_a_turned_rectangle_is_whole_in_its_upright_box(
    made: Callable[[Path], Recording], tmp_path: Path
) -> None:
    found = made(tmp_path)
    long = 60 * 0.5**0.5  # of 40x20, turned by 45 degrees
    for row, right in zip(found, (0, 2, 4), strict=False):
        expected = [200 - long / 2 + right * (made is of_cvat), 100 - long / 2, long, long]
        assert row.objects[0].box == pytest.approx(expected, abs=0.002)
        assert row.objects[0].ellipse[2:] == pytest.approx([20, 10, 0.7854], abs=0.002)
    registry.write(tmp_path / "labels", "yolo", found)
    text = (tmp_path / "labels/labels/frame_000000.txt").read_text()
    shares = [float(share) for share in text.split()[1:]]
    assert shares == pytest.approx([200 / 320, 100 / 240, long / 320, long / 240], abs=1e-4)


def test_a_mask_of_vot_has_the_box_of_its_pixels(tmp_path: Path) -> None:
    path = tmp_path / "groundtruth.txt"
    path.write_text("m10,20,5,4,0,20\nm10,20,5,4,6,2,12\n")
    found = registry.read(path, "vot", FILM)
    assert [row.objects[0].box for row in found] == [(10, 20, 5, 4), (11, 21, 2, 1)]
    assert found.left_out == ["the pixels of 2 masks, but for box and ellipse"]


def test_a_turned_ellipse_has_the_box_around_itself(tmp_path: Path) -> None:
    shape = '<ellipse frame="0" cx="200" cy="100" rx="20" ry="10" rotation="45"/>'
    found = registry.read(cvat(tmp_path, TASK, track(0, shape=shape)), "cvat", FILM)
    assert next(iter(found)).objects[0].box.width == pytest.approx(31.623, abs=0.001)


@pytest.mark.parametrize(
    "content",
    [
        track(0) + track(1, shape=BONES.format('frame="0" keyframe="1"')),
        f'<image id="0" name="a.png">{BOX.format("")}{BONES.format("")}</image>',
    ],
)
def test_skeletons_are_left_out(content: str, tmp_path: Path) -> None:
    found = registry.read(cvat(tmp_path, TASK, content), "cvat", FilmFacts())
    assert [len(row.objects) for row in found][:1] == [1]
    assert found.left_out == ["1 skeleton"]


def test_outlines_and_attributes_of_cvat_are_told(tmp_path: Path) -> None:
    attribute = '<attribute name="brand">x</attribute>'
    outline = '<polygon frame="0" occluded="0" points="9,9;49,9;29,59">{}</polygon>'
    content = track(0, shape=outline.format(attribute)) + track(1)
    found = registry.read(cvat(tmp_path, TASK, content), "cvat", FilmFacts())
    assert [len(row.objects) for row in found][:1] == [2]
    assert found.left_out == ["1 polygon, but for the box", "the attributes brand"]


@pytest.mark.parametrize(
    ("more", "left_out", "count"),
    [
        ({"bbox": [0, 0, 0, 0], "keypoints": [0, 0, 0], "num_keypoints": 0}, "1 skeleton", 0),
        ({"keypoints": [35, 65, 2], "num_keypoints": 1}, "the points of 1 skeleton", 1),
        ({"segmentation": [[9, 9, 49, 9, 29, 59]]}, "1 outline, but for box and ellipse", 1),
        ({"segmentation": [[9, 9, 49, 9, 49, 59, 9, 59]]}, "", 1),
        ({"attributes": {"occluded": True, "color": "red", "brand": "x"}},
         "the attributes brand, color", 1),
        ({"tracking_id": 3, "visibility": 0.4, "area": 9, "ignore": 0},
         "the attributes tracking_id, visibility", 1),
        ({"rotation": 0.5}, "1 angle beside a box, of which no rule is known", 1),
    ],
)  # fmt: skip
def test_points_and_angles_of_coco(
    more: dict[str, Any], left_out: str, count: int, tmp_path: Path
) -> None:
    found = registry.read(coco(tmp_path, ["frame_000000.PNG"], **more), "coco", FILM)
    assert ["; ".join(found.left_out), len(frames(found))] == [left_out, count]


def test_a_project_of_one_task_is_read(tmp_path: Path) -> None:
    meta = f"<project><tasks>{TASK}</tasks></project>"
    found = registry.read(cvat(tmp_path, meta, track(0, 5) + track(1, 5)), "cvat", FilmFacts())
    assert (found.head.width, len(next(iter(found)).objects)) == (320, 2)


def yolo(folder: Path, names: str, **texts: str) -> Path:
    (folder / "labels").mkdir(parents=True)
    (folder / "data.yaml").write_text(names)
    for name, text in texts.items():
        (folder / "labels" / f"{name}.txt").write_text(text)
    return folder


LINE = "1 0.5 0.5 0.1 0.1\n"


@pytest.mark.parametrize(
    "names",
    [
        "names: [person, 'a, b']\n", "names: {0: person, 1: 'a, b'}", "{nc: 2, names: [x, 'a, b']}",
        "# names: [x]\nnames:\n  0: person # them\n  1: a, b\nval: x\n",
        'names:\n- x\n- "a, \\u0062"', "names: [\n  x,\n  'a, b',\n]\n",
    ],
)  # fmt: skip
def test_names_of_classes_in_yaml(names: str, tmp_path: Path) -> None:
    found = registry.read(yolo(tmp_path, names, frame_000000=LINE), "yolo", FILM)
    assert [each.label for row in found for each in row.objects] == ["a, b"]


def test_names_of_classes_have_no_spaces_around_them(tmp_path: Path) -> None:
    """As CVAT writes them for Darknet, after others have edited them."""
    (tmp_path / "obj.names").write_bytes(b"car\r\nperson \r\n")
    (tmp_path / "obj_train_data").mkdir()
    (tmp_path / "obj_train_data" / "frame_000000.txt").write_text(LINE)
    found = registry.read(tmp_path / "obj_train_data", "yolo", FILM)
    assert [each.label for row in found for each in row.objects] == ["person"]
    with pytest.raises(SourceError, match="its labels are in obj_train_data; give that folder"):
        registry.read(tmp_path, "yolo", FILM)


@pytest.mark.parametrize(
    ("name", "noted"),
    [("n_12", False), ("frame_000012", False), ("12", False), ("m_12", True), ("n2_12", True)],
)
def test_labels_that_are_named_like_another_film(tmp_path: Path, name: str, noted: bool) -> None:
    found = registry.read(yolo(tmp_path, "", **{name: LINE}), "yolo", FILM)
    said = [f"its images are named {name[:-3]}; if that is another film than n, give it."]
    assert [*found.notes] == said * noted


@pytest.mark.parametrize("name", ["{}", "street_{}", "frame_{:06d}"])
@pytest.mark.parametrize("film", [FilmFacts(width=320, height=240), FILM])
@pytest.mark.parametrize("first", [0, 1])
def test_that_frames_count_from_0_is_said_where_numbers_count_from_1(
    tmp_path: Path, name: str, film: FilmFacts, first: int
) -> None:
    """As image sequences do, and Ultralytics where its film is not given."""
    texts = {name.format(number): LINE for number in range(first, first + 3)}
    found = registry.read(yolo(tmp_path, "", **texts), "yolo", film)
    assert frames(found) == [*range(first, first + 3)]
    assert any("frames are the numbers in its names" in each for each in found.notes) is (
        first == 1
    )
    assert not any("unknown" in note for note in found.notes)


def test_labels_of_a_set_for_training(tmp_path: Path) -> None:
    """Ultralytics and CVAT have them in `labels/train` and `labels/val`."""
    folder = yolo(tmp_path, "names: [x, person]\n")
    for part in ("train", "val"):
        (folder / "labels" / part).mkdir()
        (folder / "labels" / part / "frame_000003.txt").write_text(LINE)
        if part == "train":
            (row,) = registry.read(folder, "yolo", FILM)
            assert (row.frame, row.objects[0].label) == (3, "person")
    with pytest.raises(SourceError, match="its labels are in train and val; give one of"):
        registry.read(folder, "yolo", FILM)


def test_labels_in_folders_below_are_not_lost_unsaid(tmp_path: Path) -> None:
    """A film of the same name may be in each, as Roboflow has `train/labels` and `valid/labels`."""
    folder = yolo(tmp_path, "", n_7=LINE)
    (folder / "labels" / "late").mkdir()
    (folder / "labels" / "late" / "n_8.txt").write_text(LINE)
    found = registry.read(folder, "yolo", FILM)
    assert [frames(found), found.left_out] == [[6], ["the texts in its folder late"]]
    for part in ("train", "valid"):
        yolo(folder / "set" / part, "", n_7=LINE)
    with pytest.raises(SourceError, match="in train/labels and valid/labels; give one of these"):
        registry.read(folder / "set", "yolo", FILM)
    for part in ("a", "b", "c"):
        yolo(folder / "set" / part, "", n_7=LINE)
    with pytest.raises(SourceError, match="in a/labels and b/labels and c/labels and 2 more; give"):
        registry.read(folder / "set", "yolo", FILM)


def _coco(*names: str | dict[str, Any], **more: Any) -> Any:
    return lambda folder: ("coco", coco(folder, names, **more))


def _task(**task: Any) -> Any:
    return lambda folder: ("label-studio", labeled(folder, task))


def _cvat(meta: str, content: str) -> Any:
    return lambda folder: ("cvat", cvat(folder, meta, content))


def _yolo(names: str, **texts: str) -> Any:
    return lambda folder: ("yolo", yolo(folder, names, **texts))


@pytest.mark.parametrize(
    ("made", "reason"),
    [
        (_yolo("", n_1=LINE, m_11=LINE, m_12=LINE), "several films, by their names, as m and n"),
        (_task(annotations=[SEEN, SEEN]), "2 annotations, as of several people"),
        (_task(annotations=[CANCELLED], predictions=[SEEN]), "annotations are cancelled"),
        (_task(annotations=[{"result": [region(25, 40)]}]), "a film of 40 frames"),
        (_task(image="1.png", annotations=[{"label": "car", "coordinates": {}}]), "`result`"),
        (_task(annotations=[{"result": [region(turned=400)]}]), "rotation is 400"),
        (_task(annotations=[{"result": [{"type": "rectanglelabels", "value": {}}]}]),
         "no box of a video, but rectanglelabels; export images as COCO"),
        (_coco({"file_name": "1.png", "video_id": 1}, {"file_name": "2.png", "video_id": 2}),
         "several films, by their video_id"),
        (_coco("1.png", {"file_name": "2.png", "width": 640}), "several films, by their size"),
        (_coco("frame_000000.PNG", "frame_000000.PNG"), "several of its images have one number"),
        (_coco("frame_000000.PNG", "frame_000000_1.PNG"), "a project's second video"),
        (_coco("frame-4f3e2a19.png"), "ends in a hash"),
        (_coco("1.png", attributes={"track_id": "a7"}), "track_id is 'a7'"),
        (_coco("1.png", category_id=4), "category 4 is missing"),
        (_coco("1.png", attributes={"occluded": "partly"}), "occluded is 'partly'"),
        (_cvat("", images("a/1.png", "b/1.png")), "several films, by their folder"),
        (_cvat(f"<project><tasks>{2 * TASK}</tasks></project>", track(0)), "2 tasks of a project"),
        (_cvat(TASK, '<image id="0"><points occluded="0" points=""/></image>'), "has no points"),
        (_cvat(TASK, track(0, shape=BOX.format(' rotation="-400"'))), "rotation is -400"),
        (_yolo("names: [car]", frame_000000=LINE), "no class 1"),
        (_yolo("names: [car", frame_000000=LINE), "the list of names has no end"),
        (_yolo("", frame_000000="0 .1 .1 .2 .1 .2 .2 .1 .2\n"), "turned boxes and poses"),
    ],
)  # fmt: skip
def test_what_is_not_clear_is_refused(made: Any, reason: str, tmp_path: Path) -> None:
    name, path = made(tmp_path)
    with pytest.raises(SourceError) as raised:
        registry.read(path, name, FILM)
    assert reason in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4]}]', "list of results of COCO"),
        ('[{"name": "a-01.jpg", "labels": [{"box2d": {"x1": 1}}]}]', "list in JSON of another"),
        ('[{"image": "1.png", "annotations": [{"coordinates": {}}]}]', "list in JSON of another"),
        ('{"videos": [], "annotations": [{"video_id": 1}]}', "it is JSON of another tool"),
        (
            "frame,id,left,top,width,height\r0,1,1,2,3,4\r",
            "its lines end in carriage returns alone",
        ),
        ('{"info": {}, "categories": {}, "items": [{"id": "a"}]}', "dataset of Datumaro"),
        ('{"version": "5.0.1", "shapes": [{"points": [[1, 2], [3, 4]]}]}', "picture of labelme"),
        ('{"a.jpg9": {"filename": "a.jpg", "regions": []}}', "project of VIA"),
        ('{"project": {}, "file": {"1": {"fname": "a.mp4"}}}', "project of VIA"),
        ('{"version": "2.0", "item": {"slots": []}}', "file of Darwin"),
        ('{"key": "a", "objects": [{"classTitle": "car"}]}', "file of Supervisely"),
        ("<annotation><object><bndbox/></object></annotation>", "picture of Pascal VOC"),
        ("1,1,101,81,40,60,1,3\n", "--from vot for corners, and for frame, id, box"),
        ("version: 1\n", "If it is none of these, convert it to one"),
        (" ,Area,X,Y,Slice\n1,10,1,2,1\n", "columns are , Area, X, Y, Slice; those of boxes are"),
        ("PK\x03\x04\0\0", "a ZIP archive, or a workbook; unpack it, or save"),
        ("\ufeff", "a.json: it is empty; make the file anew"),
        ("\n\n", "a.json: it is empty; make the file anew"),
    ],
)
def test_files_that_are_not_read_are_named(text: str, reason: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(SourceError, match=reason):
        registry.recognized(tmp_path / "a.json")


def test_shares_of_the_picture_are_not_taken_for_pixels(tmp_path: Path) -> None:
    path = coco(tmp_path, ["1.png"], bbox=[0.4, 0.5, 0.2, 0.25])
    with pytest.raises(SourceError, match="all of its boxes within a pixel, as shares"):
        registry.read(path, "coco", FILM)
    document = json.loads(path.read_text())
    document["annotations"] += [{**document["annotations"][0], "bbox": [0, 0, 1.5, 0.5]}]
    path.write_text(json.dumps(document))
    assert len(registry.read(path, "coco", FILM).frames[0].objects) == 2


@pytest.mark.parametrize(
    ("boxes", "said"),
    [
        ([[200, 60, 300, 110], [200, 60, 300, 110]], True),
        ([[200, 60, 300, 110], [200, 60, 30, 40]], False),
        ([[300, 60, 100, 50], [300, 60, 100, 50]], False),
    ],
)
def test_boxes_that_fit_only_as_corners_are_said(
    boxes: list[list[int]], said: bool, tmp_path: Path
) -> None:
    path = coco(tmp_path, ["0.png", "1.png"])
    document = json.loads(path.read_text())
    del document["categories"]
    for each, box in zip(document["annotations"], boxes, strict=True):
        each["bbox"] = box
    path.write_text(json.dumps(document))
    no_classes, *more = registry.read(path, "coco", FILM).notes
    assert "no categories" in no_classes
    assert ["320x240 only as left, top, right, bottom" in note for note in more] == [True] * said
