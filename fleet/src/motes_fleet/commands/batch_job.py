"""What a job of `motes batch` does: the command line that a user would type, in a worker."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterator
from pathlib import Path

from motes.cli import NOT_FOUND, call
from motes.correction import History
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.work import Made


def make(job: Job, folder: Path, form: str, overlay: bool) -> Made:
    """Write the rows of a job, its events and its annotated video into a folder.

    The files of the job are on this machine, and the folder is empty. The rows end in `form`:
    Parquet is made of those that the command has written.

    Raises
    ------
    MotesError
        As the command does.
    """
    rows = folder / ("rows.csv" if job.rows is None else f"rows{Path(job.rows).suffix}")
    wanted = folder / f"rows.{form}"
    with contextlib.redirect_stderr(io.StringIO()), warnings(job.source) as notes:
        code = call(command_line(job, rows, overlay=overlay))
        history = History.beside(rows)
        assert history is not None  # every such command leaves one
        if rows != wanted:
            call(["convert", str(rows), str(wanted), *_option("label", job.label)])
            rows.unlink()
            History.path(rows).unlink()
    if code == NOT_FOUND:
        notes.insert(0, f"Nothing was ever found by {job.do}.")
    return len(history.used), " ".join(dict.fromkeys(notes)) or None


def command_line(job: Job, rows: Path, *, overlay: bool) -> list[str]:
    """Return the command that makes the rows of a job, as words."""
    words = [job.do, job.source, *tracker_options(job), f"--output={rows}"]
    if job.do == "refine":
        words.insert(2, str(job.rows))
    else:
        words += [f"--start={job.start}", f"--stride={job.stride}", *_option("end", job.end)]
        words += [f"--overlay={rows.with_name('overlay.mp4')}"] * overlay
    if job.do == "watch":
        words += [f"--events={rows.with_name('events.jsonl')}"]
    words += ["--init=" + ",".join(map(repr, region)) for region in job.init]
    for name in ("detect", "keyframes", "detector", "places", "fps"):
        words += _option(name, getattr(job, name))
    return words


def tracker_options(job: Job) -> list[str]:
    """Return the options of the tracker of a job: preset, configuration, network, seed."""
    words = _option("preset", job.preset) + _option("config", job.config)
    words += _option("network", ",".join(job.network) or None)
    if job.do == "refine" and not words and not job.seed:
        return []  # it is that of the rows
    return [*words, f"--seed={job.seed}"]


def _option(name: str, value: object) -> list[str]:
    """Return an option as one word: a value may begin with a minus sign."""
    return [] if value is None else [f"--{name}={value}"]


@contextlib.contextmanager
def warnings(source: str) -> Iterator[list[str]]:
    """Collect what motes warns of in the block: what is wrong with a film, or assumed of it."""
    found = list[str]()

    def keep(record: logging.LogRecord) -> None:
        text = record.getMessage().removeprefix(f"{source}: ")
        found.append(text[:1].upper() + text[1:])

    handler = logging.Handler(logging.WARNING)
    handler.emit = keep  # type: ignore[method-assign]
    logger = logging.getLogger("motes")
    logger.addHandler(handler)
    try:
        yield found
    finally:
        logger.removeHandler(handler)
