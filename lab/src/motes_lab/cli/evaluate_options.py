"""The options of `motes-lab evaluate`, and their checks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.options import FLAG, OUTPUT, REPEATED, RUN, Cluster, Overwrite, Workers
from motes.cluster.pool import TIME_LIMIT
from motes.core.errors import ConfigError, FormatError, SourceError
from motes_lab.inputs import DATASET, FirstPixel, Only, Seeds
from motes_lab.protocols.perturbations import MAX_FRAMES
from motes_lab.protocols.sot import MIN_FRAMES
from motes_lab.report.reference import Reference
from motes_lab.report.speed_ratio import PEER


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
        list[Literal["ope", "pixel", "sre", "tre", "reset", "robust"]] | None,
        REPEATED,
        Parameter(
            help="Protocol; may be repeated. ope: one pass. pixel: three starts, with the first "
            "box moved by 0, -1 and 1 pixels. sre: 12 perturbed starts. tre: later starts. reset: "
            "a new start after each failure. robust: 24 perturbed views. The default is ope."
        ),
    ] = None
    robust: Annotated[bool, FLAG, Parameter(help="The same as --protocol robust.")] = False
    max_frames: Annotated[
        int, Parameter(help="Longest view of the protocol robust, in frames; 5 or more.")
    ] = MAX_FRAMES
    seeds: Seeds = 5
    workers: Workers = None
    cluster: Cluster = None
    time_limit: Annotated[
        float,
        Parameter(
            help="Seconds for a tracker on a sequence in a protocol; in robust, on each view."
        ),
    ] = TIME_LIMIT

    def check(self) -> None:
        """Check the numbers; raise a ConfigError for one that makes no sense."""
        check_counts(seeds=self.seeds)
        if self.max_frames < MIN_FRAMES:
            raise ConfigError(f"--max-frames is {self.max_frames}; give {MIN_FRAMES} or more.")
        worker_count(self.workers)
        if not 0 < self.time_limit < float("inf"):
            raise ConfigError(f"--time-limit is {self.time_limit:g}; give a number of seconds.")

    def protocols(self) -> list[str]:
        """Return the protocols, each once; none if none is named."""
        return list(dict.fromkeys([*(self.protocol or []), *["robust"] * self.robust]))


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
    """The folder of the results, and the comparisons of the report."""

    out: Annotated[Path, Parameter(help="Folder of the results.")] = Path("evaluation")
    reference: Annotated[
        Path | None, Parameter(help="CSV file of published results, for the report.")
    ] = None
    peer: Annotated[
        str | None,
        Parameter(
            help="Tracker that the times of the others are compared with. The default is "
            f"{PEER}, if it is measured."
        ),
    ] = None
    resume: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Keep existing tracks, and run what is missing. Trackers, protocols, sequences "
            "and seeds may be added."
        ),
    ] = False
    overwrite: Overwrite = False

    def published(self) -> Reference | None:
        """Return the results of --reference; raise a SourceError if they cannot be read."""
        if self.reference is None:
            return None
        try:
            return Reference.load(self.reference)
        except FormatError as error:
            raise SourceError(str(error)) from None


def check_kind(many: bool, data: DatasetOptions, run: RunOptions, report: ReportOptions) -> None:
    """Check that the options fit the dataset.

    Parameters
    ----------
    many
        Whether the dataset has many objects.
    data, run, report
        The options.

    Raises
    ------
    ConfigError
        If an option is for the other kind of dataset, or a tracker is missing.
    """
    single = {
        "protocol": run.protocols() or None,
        "annotation": data.annotation,
        "first-pixel": data.first_pixel,
        "reference": report.reference,
        "peer": report.peer,
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
    if report.peer is not None and report.peer not in (run.tracker or ()):
        raise ConfigError(
            f"--peer {report.peer} is not measured; give --tracker {report.peer} as well."
        )
