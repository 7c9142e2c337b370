"""The options of `motes-lab evaluate`, and their checks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.options import FLAG, OUTPUT, REPEATED, RUN, Cluster, Overwrite, Workers
from motes.cluster.pool import TIME_LIMIT
from motes.core.errors import ConfigError
from motes_lab.inputs import DATASET, FirstPixel, Only, Seeds


@Parameter(name="*", group=RUN)
@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The trackers, the protocols and the limits of the runs."""

    tracker: Annotated[
        list[str] | None,
        REPEATED,
        Parameter(
            help="Tracker to measure; may be repeated. The default is nummiaro for datasets with "
            "one object; for many objects, name one."
        ),
    ] = None
    detector: Annotated[
        str | None,
        Parameter(
            help="Detector of many objects, in place of det/det.txt: background, an .onnx file, or "
            "the module:callable of a Python detector."
        ),
    ] = None
    protocol: Annotated[
        list[Literal["ope", "pixel"]] | None,
        REPEATED,
        Parameter(
            help="Protocol; may be repeated. ope: one pass. pixel: three starts, with the first "
            "box moved by 0, -1 and 1 pixels. The default is ope."
        ),
    ] = None
    seeds: Seeds = 5
    workers: Workers = None
    cluster: Cluster = None
    time_limit: Annotated[
        float, Parameter(help="Seconds for a tracker on a sequence in a protocol.")
    ] = TIME_LIMIT

    def check(self) -> None:
        """Check the numbers; raise a ConfigError for one that makes no sense."""
        check_counts(seeds=self.seeds)
        worker_count(self.workers)
        if not 0 < self.time_limit < float("inf"):
            raise ConfigError(f"--time-limit is {self.time_limit:g}; give a number of seconds.")


@Parameter(name="*", group=DATASET)
@dataclass(frozen=True, kw_only=True)
class DatasetOptions:
    """The part of a dataset that is measured."""

    sequence: Only = None
    annotation: Annotated[
        Path | None, Parameter(help="File of the ground truth, if DATASET is a video.")
    ] = None
    first_pixel: FirstPixel = None


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class ReportOptions:
    """The folder of the results."""

    out: Annotated[Path, Parameter(help="Folder of the results.")] = Path("evaluation")
    resume: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Keep existing tracks, and run what is missing. Trackers, protocols, sequences "
            "and seeds may be added."
        ),
    ] = False
    overwrite: Overwrite = False


def check_kind(many: bool, data: DatasetOptions, run: RunOptions) -> None:
    """Check that the options fit the dataset.

    Parameters
    ----------
    many
        Whether the dataset has many objects.
    data, run
        The options.

    Raises
    ------
    ConfigError
        If an option is for the other kind of dataset, or a tracker is missing.
    """
    single = {
        "protocol": run.protocol,
        "annotation": data.annotation,
        "first-pixel": data.first_pixel,
    }
    kinds = ["one object", "many objects"]
    for name, value in (single if many else {"detector": run.detector}).items():
        if value is not None:
            raise ConfigError(
                f"--{name} is for datasets with {kinds[not many]}, but this has {kinds[many]}; "
                f"leave it out."
            )
    if many and not run.tracker:
        raise ConfigError(
            "There is no tracker; name some, such as --tracker trackers:sort --tracker "
            "trackers:bytetrack."
        )
