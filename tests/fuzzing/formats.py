"""Files of every format that `motes convert` reads, lenses, and tables of jobs."""

from functools import partial
from unittest.mock import patch

from lens_files import lens_file
from motes import Ellipse, Status
from motes.formats import registry
from motes.formats.recording import FilmFacts, Recording
from motes.mot.analytics.lens import Lens
from motes.rows.schema import ENDING
from motes.rows.writer import JournalWriter
from motes_fleet.cluster.table import JobTable
from recordings import placed

from .campaign import Kind
from .outcomes import check_finite, outcome, put, scratch

FACTS = FilmFacts(source="film.mp4", width=64, height=48, fps=25.0, label="car")
NAMES = {
    "csv": "a.csv", "jsonl": "a.jsonl", "mot": "a.txt", "mot-truth": "gt.txt",
    "mot-detections": "det.txt", "otb": "a.otb.txt", "vot": "a.vot.txt", "coco": "a.json",
    "cvat": "a.xml", "label-studio": "a.ls.json",
    "keyframes": "a.keyframes.csv", "journal": f"a.json{ENDING}",
}  # fmt: skip
TABLES = {
    "csv": b"source,region,label\na.mp4,\"1,2,30,40\",x\nb.mp4,\"1,2,30,40\",\n",
    "jsonl": b'{"source": "a.mp4", "init": [1, 2, 30, 40]}\n{"source": "b.mp4", "do": "watch"}\n',
    "toml": b'[[job]]\nsource = "a.mp4"\nregion = [1, 2, 30, 40]\n[[job]]\nsource = "b.mp4"\n',
}  # fmt: skip


def _one() -> Recording:
    """Return an object that turns, and is absent in a frame."""
    objects = [
        placed(frame, Ellipse(9.5 + frame, 20, 8, 5, 0.1 * frame), 1, 0.75)
        for frame in (0, 1, 2, 4, 5)
    ]
    return Recording.of(FACTS, objects, {frame: frame / 25 for frame in range(6)})


def _several() -> Recording:
    """Return two objects, one of them hidden in the end."""
    objects = []
    for frame in range(4):
        status = Status.OCCLUDED if frame == 3 else Status.TRACKING
        one, two = ((5.0 * frame, 9, 12, 10), (40.0 - frame**2, 20.5, 9, 18))
        objects.append(placed(frame, Ellipse.from_box(one), 1, 0.9))
        objects.append(placed(frame, Ellipse.from_box(two), 2, 0.5, status, "bus"))
    return Recording.of(FACTS, objects, {frame: frame / 25 for frame in range(4)})


def seeds(name: str) -> list[bytes]:
    single = name != "journal" and registry.FORMATS.resolve(name).single
    found = []
    for number, recorded in enumerate([_one(), *[_several()] * (not single)]):
        path = scratch() / f"seed-{number}-{NAMES[name]}"
        path.unlink(missing_ok=True)
        if name == "journal":
            writer = JournalWriter(path, recorded.head)
            for row in recorded:
                writer.add(row)
            writer.close()
        else:
            registry.write(path, name, recorded)
        found.append(path.read_bytes())
    return found


def check(name: str, data: bytes) -> str:
    """Read a file, and write what it holds as rows and as a document."""
    path = put(NAMES[name], data)

    def read() -> None:
        recorded = registry.read(path, name, FACTS)
        for row in recorded:
            check_finite([row.time])
            for each in row.objects:
                assert each.placed == (each.status is not Status.ABSENT)
                check_finite([*each.ellipse, each.confidence] if each.placed else ())
        registry.write(scratch() / "b.csv", "csv", recorded)
        if recorded.head.width > 0 and recorded.head.height > 0:
            registry.write(scratch() / "b.json", "coco", recorded)

    return outcome(read)


def lenses() -> list[bytes]:
    return [
        lens_file(60.0, (-0.25, 0.1, 1e-3, 0.0, 0.0), (64, 48)).encode(),
        b'<?xml version="1.0"?>\n<opencv_storage>\n<image_width>64</image_width>\n<camera_matrix '
        b'type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt><data>60. 0. 32. 0. 60. 24.'
        b' 0. 0. 1.</data></camera_matrix>\n<distortion_coefficients type_id="opencv-matrix"><rows>'
        b"1</rows><cols>4</cols><dt>d</dt><data>0.1 0. 0. 0.</data></distortion_coefficients>\n"
        b"</opencv_storage>\n",
    ]


def check_lens(data: bytes) -> str:
    """Read a lens, and look for the places of some pixels."""

    def read() -> None:
        lens = Lens.parse(data.decode(errors="replace"))
        for point in ((0.0, 0.0), (31.5, 23.5), (63.0, 47.0), (-1e4, 1e4)):
            check_finite(lens.undistorted(point) or ())

    return outcome(read)


def check_table(form: str, data: bytes) -> str:
    """Read a table of jobs, and check its rows."""
    path = put(f"jobs.{form}", data)

    def read() -> None:
        with patch("motes_fleet.cluster.table.stamp", return_value="there"):
            _, count, problems = JobTable(str(path)).problems(lambda _: None)
        assert bool(count) == bool(problems)

    return outcome(read)


KINDS = (
    *(Kind(f"as-{name}", partial(seeds, name), partial(check, name)) for name in NAMES),
    Kind("lenses", lenses, check_lens),
    *(
        Kind(f"jobs-{form}", partial(list, (text,)), partial(check_table, form))
        for form, text in TABLES.items()
    ),
)
"""A kind for each format of one file, for lenses, and for each form of a table of jobs."""
