"""The folder of an evaluation: its record of the run, and checks before it is used again."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

import msgspec
from msgspec.structs import replace

from motes import Config, ConfigError, FormatError, __version__
from motes.core import PARTIAL, leftovers, write_whole
from motes.rows import text_name
from motes_lab.adapters.registry import TrackerSpec
from motes_lab.runner import Job


class Record(Config, frozen=True):
    """The settings of an evaluation, saved as `run.json` so that it can be resumed."""

    motes: str
    """The version of motes."""
    dataset: str
    """The path of the dataset."""
    sequences: dict[str, str]
    """Names, and digests of their truth and detections."""
    trackers: dict[str, str]
    """Names and configurations."""
    protocols: tuple[str, ...]
    seeds: int
    time_limit: float
    """Those of the last run."""


def record(
    dataset: Path,
    jobs: Iterable[Job],
    specs: Iterable[TrackerSpec],
    protocols: Iterable[str],
    seeds: int,
    time_limit: float,
) -> Record:
    """Return the record of an evaluation."""
    sequences = {job.sequence.name: job.sequence for job in jobs}
    return Record(
        motes=__version__,
        dataset=text_name(os.path.abspath(dataset)),
        sequences={name: sequence.digest for name, sequence in sequences.items()},
        trackers={spec.name: spec.configuration for spec in specs},
        protocols=tuple(protocols),
        seeds=seeds,
        time_limit=time_limit,
    )


RECORD = "run.json"
FILES = (RECORD, "results.csv", "summary.md")
"""The files that an evaluation writes beside the folder `tracks`."""


def prepare(out: Path, now: Record, *, resume: bool = False, overwrite: bool = False) -> None:
    """Make the folder of an evaluation; nothing is written if it cannot be used.

    Raises
    ------
    ConfigError
        If both `resume` and `overwrite` are given.
    FormatError
        If the folder holds an evaluation and neither is given; if the evaluation to be resumed had
        other settings; or if the folder cannot be written.
    """
    if resume and overwrite:
        raise ConfigError("--resume and --overwrite contradict each other; give one of them.")
    present = [name for name in (*FILES, "tracks") if (out / name).exists()]
    if present and not (resume or overwrite):
        raise FormatError(
            f"{out} holds an evaluation ({present[0]}); continue it with --resume, replace it with "
            f"--overwrite, or choose another --out."
        )
    if present and resume:
        now = _resumed_record(out, now)
    try:
        if overwrite:
            _remove_results(out)
        out.mkdir(parents=True, exist_ok=True)
        write_whole(out / RECORD, msgspec.json.format(msgspec.json.encode(now)) + b"\n")
    except OSError as error:
        raise FormatError(
            f"{out} cannot be written: {error.strerror}; make room, or choose another --out."
        ) from None


def _resumed_record(out: Path, now: Record) -> Record:
    """Return the record of a resumed evaluation; raise a FormatError if its settings differ."""
    try:
        before = msgspec.json.decode((out / RECORD).read_bytes(), type=Record)
    except (OSError, msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise FormatError(
            f"{out} cannot be resumed, as its {RECORD} cannot be read ({why}); replace it with "
            f"--overwrite, or choose another --out."
        ) from None
    changed = [
        f"tracker {name}, which had another configuration"
        for name, text in now.trackers.items()
        if before.trackers.get(name, text) != text
    ]
    changed += [
        f"sequence {name}, which had other truth or detections"
        for name, text in now.sequences.items()
        if before.sequences.get(name, text) != text
    ]
    if before.dataset != now.dataset:
        changed.append(f"dataset, which was {before.dataset}")
    if before.motes != now.motes:
        changed.append(f"version of motes, which was {before.motes}")
    if changed:
        raise FormatError(
            f"{out} cannot be resumed with this {changed[0]}; replace it with --overwrite, or "
            f"choose another --out."
        )
    return replace(
        now, sequences=before.sequences | now.sequences, trackers=before.trackers | now.trackers
    )


def _remove_results(out: Path) -> None:
    """Remove the files that an evaluation wrote, and nothing else."""
    tracks = [
        path
        for ending in (".csv", ".txt", f".csv{PARTIAL}", f".txt{PARTIAL}")
        for path in out.glob(f"tracks/*/*/*{ending}")
    ]
    summaries = [path for name in FILES for path in (out / name, *leftovers(out / name))]
    for path in [*summaries, *tracks]:
        path.unlink(missing_ok=True)
    for folder in [*out.glob("tracks/*/*/"), *out.glob("tracks/*/"), out / "tracks"]:
        with contextlib.suppress(OSError):  # a user has put other files there
            folder.rmdir()
