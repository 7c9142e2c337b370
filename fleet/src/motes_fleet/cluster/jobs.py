"""A job: a film, and what is done with it."""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal

import msgspec
from msgspec.structs import astuple, replace

from motes import MotesError
from motes.core import as_ellipse, check_label, words
from motes.sot import Network
from motes.video import check_rate, is_recorded

Region = tuple[float, ...]


class Job(msgspec.Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A row of a table of jobs; the attributes are its columns."""

    name: str = ""
    """Its name, which no other job has; by default that of the film without its ending."""
    source: str
    """A video file, a folder or a pattern of images, or an address that fsspec knows."""
    do: Literal["track", "watch", "refine"] = "track"
    """What `motes track`, `motes watch` or `motes refine` does."""
    init: tuple[Region, ...] = ()
    """For track: the target in the first frame, x,y,width,height or x,y,a,b,theta; or several, with
    semicolons between them."""
    detect: Literal["face"] | None = None
    """For track: `face`, to wait for a face."""
    keyframes: str | None = None
    """For track and refine: a file of keyframes."""
    rows: str | None = None
    """For refine: the rows that are corrected."""
    detector: str | None = None
    """For watch: its detector."""
    places: str | None = None
    """For watch: a TOML file of lines and zones, whose events are counted."""
    preset: str | None = None
    config: str | None = None
    seed: int = 0
    """The tracker: a preset, a TOML file whose values replace those of the preset, and the seed of
    the random numbers."""
    network: tuple[str, ...] = ()
    """For track: the files of a trained network that joins the tracker."""
    start: int = 0
    end: int | None = None
    stride: int = 1
    """The frames that are used."""
    fps: float | None = None
    """Frames per second of images."""
    label: str | None = None
    """Any text of one line; it is copied to the table of results, and in Parquet it is the class of
    objects without one."""

    @property
    def files(self) -> list[tuple[str, str]]:
        """The columns and paths of the files that it reads, its source first."""
        columns = ("source", "keyframes", "rows", "places", "config")
        found = [(name, value) for name in columns if (value := getattr(self, name)) is not None]
        if self.detector is not None and os.path.splitext(self.detector)[1] in (".onnx", ".txt"):
            found.append(("detector", self.detector))
        return [*found, *(("network", path) for path in self.network)]

    def with_files(self, place: Callable[[str], str]) -> Job:
        """Return the job with the path `place(path)` for that of each file."""
        own = {name: place(path) for name, path in self.files if name != "network"}
        return replace(self, **own, network=tuple(map(place, self.network)))

    def digest(self, *more: object) -> str:
        """Return a text that differs where the job, or `more`, differs."""
        # All values: which ones count as defaults changes when a job goes to another process.
        data = msgspec.json.encode([astuple(self), *more])
        return hashlib.sha256(data).hexdigest()[:16]


COLUMNS = {each.name: each.type for each in msgspec.structs.fields(Job)}


def read_job(row: Mapping[str, Any], name: str) -> tuple[Job | None, list[str]]:
    """Return the job of a row of a table, and all that is wrong with it but for its files.

    Empty fields count as missing. Paths become absolute: a worker may have another folder. The job
    has `name` if the row has none. It is None where values have other types than their columns.
    """
    wrong = [_unknown(column) for column in row if column not in COLUMNS]
    given = {key: row[key] for key in COLUMNS if row.get(key) not in (None, "")}
    if "init" in given:
        given["init"] = _regions(given["init"])
    if isinstance(networks := given.get("network"), str):
        with noted(wrong):
            del given["network"]
            given["network"] = Network.named([path.strip() for path in networks.split(",")]).paths
    mistyped = list[str]()
    for key, value in given.items():
        try:
            given[key] = msgspec.convert(value, COLUMNS[key], strict=False)
        except msgspec.ValidationError:
            takes = words(COLUMNS[key])
            mistyped.append(f"column {key}: got {row[key]!r:.80}; it takes {takes}.")
    if mistyped:
        return None, [*wrong, *mistyped]
    job = Job(**{"source": "", "name": name} | given).with_files(_absolute)
    return job, [*wrong, *_mistakes(job)]


def _unknown(column: str) -> str:
    """Return that there is no such column, with the nearest known name."""
    near = difflib.get_close_matches(str(column), COLUMNS, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(COLUMNS)}."
    return f"There is no column {column!r}; {hint}"


def _absolute(path: str) -> str:
    return os.path.abspath(path) if path and "://" not in path else path


def _regions(value: Any) -> Any:
    """Return regions from `1,2,3,4`, `1,2,3,4; 5,6,7,8`, a list of numbers, or a list of lists."""
    if isinstance(value, str):
        parts = (part.split(",") for part in value.split(";") if part.strip())
        value = [[number.strip() for number in part] for part in parts]
    elif isinstance(value, (list, tuple)) and value and not isinstance(value[0], (list, tuple)):
        value = [value]
    return value


@contextlib.contextmanager
def noted(mistakes: list[str]) -> Iterator[None]:
    """Add the message of a MotesError to some mistakes, and go on after the block."""
    try:
        yield
    except MotesError as error:
        mistakes.append(str(error))


def _mistakes(job: Job) -> list[str]:
    """Return all that is wrong with a job, but for its files."""
    wrong = list[str]()
    if not job.source:
        wrong.append("it has no source; name a film.")
    for region in job.init:
        with noted(wrong):
            as_ellipse(region)
    with noted(wrong):
        check_rate(job.fps)
    with noted(wrong):
        check_label(job.label or "-")
    if job.seed < 0 or job.start < 0 or job.stride < 1:
        wrong.append("seed and start are 0 or more, and stride is 1 or more.")
    if not is_recorded(job.source) and not job.source.startswith(("http://", "https://")):
        wrong.append(f"{job.source} is live and has no end; motes watch is for it.")
    ways = {
        "track": ("init", "keyframes", "detect", "network"),
        "watch": ("detector", "places"),
        "refine": ("keyframes", "rows"),
    }
    for column in ("init", "detect", "keyframes", "detector", "network", "places", "rows"):
        if getattr(job, column) and column not in ways[job.do]:
            wrong.append(f"{job.do} takes no {column}; empty that column.")
    if job.do == "refine" and not (job.keyframes and job.rows):
        wrong.append("refine needs rows and keyframes; fill both columns.")
    if job.do == "track" and sum(map(bool, (job.init, job.keyframes, job.detect))) != 1:
        wrong.append("track takes one of init, keyframes and detect; fill one of them.")
    if job.do == "track" and job.keyframes and job.stride != 1:
        wrong.append("stride is not for keyframes; empty that column.")
    return wrong
