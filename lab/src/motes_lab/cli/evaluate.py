"""`motes-lab evaluate`: measure trackers on sequences with ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cyclopts import App

from motes import ConfigError
from motes_lab import runner
from motes_lab.adapters.registry import mot_tracker_spec, resolve, with_detector
from motes_lab.cli.evaluate_options import DatasetOptions, ReportOptions, RunOptions, check_kind
from motes_lab.cli.evaluate_run import run_jobs, write_all
from motes_lab.datasets.mot import MotSequence, has_mot_sequences, load_mot_dataset
from motes_lab.datasets.sot import Sequence as Film, load_dataset
from motes_lab.inputs import chosen, first_pixels, lines, refuse_none
from motes_lab.run_folder import prepare, record
from motes_lab.runner import Pass

TRACKERS = """\
Trackers:
  nummiaro, mean_shift          presets
  default:network=FILE,FILE     the default tracker with a trained network
  FILE.toml                     a configuration: a preset with other values
  cv2:csrt, cv2:kcf, cv2:mil, cv2:mosse, cv2:medianflow, cv2:camshift
  cv2:nano=BACKBONE,HEAD        NanoTrack, with its two ONNX files
  cv2:vit=NETWORK               VitTrack, with its ONNX file
  module:factory                a Python callable; it returns an object with
                                init(image, box) and update(image)
Trackers of many objects:
  trackers:sort, trackers:bytetrack, trackers:ocsort, trackers:botsort,
  trackers:cbiou, trackers:mcbyte
  module:factory                a Python callable; it returns an object with
                                update(frame, detections)
  results=FOLDER                existing results: SEQUENCE.txt

"""

app = App(name="evaluate", help_epilogue=TRACKERS, help_format="plaintext")


@app.default
def evaluate(
    dataset: Path,
    /,
    *,
    data: DatasetOptions = DatasetOptions(),
    run: RunOptions = RunOptions(),
    report: ReportOptions = ReportOptions(),
) -> int:
    """Measure trackers on sequences with ground truth.

    Writes results.csv, summary.md and all tracks (tracks/) into a folder. Where a
    sequence or tracker fails, its name is printed, and the others go on.

    Parameters
    ----------
    dataset
        A folder of sequences (OTB, VOT, GOT-10k or, for many objects, MOT), or a video.
    """
    run.check()
    many = has_mot_sequences(dataset)
    check_kind(many, data, run)

    films: Sequence[Film] | Sequence[MotSequence]
    if many:
        films, problems = chosen(*load_mot_dataset(dataset), data.sequence)
    else:
        loaded = load_dataset(dataset, first_pixels(data.first_pixel), data.annotation)
        films, problems = chosen(*loaded, data.sequence)
    entries, unusable = resolve(run.tracker or ["nummiaro"], mot_tracker_spec if many else None)
    if not entries:
        raise ConfigError("There is no tracker to run. " + lines(unusable))
    if run.detector is not None:
        entries = with_detector(entries, run.detector)
    protocols = ["mot"] if many else [*dict.fromkeys(run.protocol or ["ope"])]
    jobs, unreadable = runner.plan(entries, films, protocols, run.seeds)
    problems += unreadable
    refuse_none(dataset, jobs, problems)
    problems += unusable
    now = record(dataset, jobs, entries, protocols, run.seeds, run.time_limit)
    prepare(report.out, now, resume=report.resume, overwrite=report.overwrite)

    errors: dict[Pass, str] = {}
    interrupted: KeyboardInterrupt | None = None
    try:
        run_jobs(jobs, report.out, run, errors)
    except KeyboardInterrupt as interrupt:
        interrupted = interrupt
    # Results are in the order of the trackers.
    jobs = [job for entry in entries for job in jobs if entry in job.specs]
    title = f"Trackers on {dataset.resolve().name}"
    return write_all(jobs, report.out, errors, problems, title, interrupted)
