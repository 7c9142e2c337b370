"""The options of `motes-lab evaluate`, and their checks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from motes import ConfigError
from motes.cli import options
from motes_fleet.cluster import pool as pools
from motes_fleet.commands.workers import Cluster, Workers, check_run
from motes_lab.inputs import (
    DATASET,
    FLAG,
    OUTPUT,
    REPEATED,
    RUN,
    FirstPixel,
    Only,
    Overwrite,
    Seeds,
)


@options(RUN)
class RunOptions:
    """The trackers, the protocols and the limits of the runs."""

    tracker: Annotated[list[str] | None, REPEATED] = None
    """Tracker to measure; may be repeated. The default is nummiaro for datasets with one object;
    for many objects, name one."""
    detector: str | None = None
    """Detector of many objects, in place of det/det.txt: background, an .onnx file, or the
    module:callable of a Python detector."""
    protocol: Annotated[list[Literal["ope", "pixel"]] | None, REPEATED] = None
    """Protocol; may be repeated. ope: one pass. pixel: three starts, with the first box moved by 0,
    -1 and 1 pixels. The default is ope."""
    seeds: Seeds = 5
    workers: Workers = None
    cluster: Cluster = None
    time_limit: float = pools.TIME_LIMIT
    """Seconds for a tracker on a sequence in a protocol."""

    def check(self) -> None:
        """Check the numbers; raise a ConfigError for one that makes no sense."""
        check_run(self.workers, self.time_limit, seeds=self.seeds)


@options(DATASET)
class DatasetOptions:
    """The part of a dataset that is measured."""

    sequence: Only = None
    annotation: Path | None = None
    """File of the ground truth, if DATASET is a video."""
    first_pixel: FirstPixel = None


@options(OUTPUT)
class ReportOptions:
    """The folder of the results."""

    out: Path = Path("evaluation")
    """Folder of the results."""
    resume: Annotated[bool, FLAG] = False
    """Keep existing tracks, and run what is missing. Trackers, protocols, sequences and seeds may
    be added."""
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
