"""`motes watch RIG.toml`: several cameras, with identities that objects keep between them."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from motes import (
    ConfigError,
    Ellipse,
    FormatError,
    KnownTarget,
    MotesError,
    SourceError,
    Track,
    TrackWriter,
    named_detector,
    open_source,
)
from motes.cli import DONE, NOT_FOUND, PARTIAL, check_not_source, default_output, log
from motes.core import counted, interrupts
from motes.mot import WatchConfig, check_code
from motes.rows import FORMS, FrameRow
from motes.video import is_recorded
from motes_fleet.cameras.camera_loop import PRESET
from motes_fleet.cameras.camera_report import CameraMessage, CameraReport
from motes_fleet.cameras.rig import RigRunner
from motes_fleet.cameras.rig_config import Camera, Rig


def frame_row(report: CameraReport, identities: Mapping[int, int]) -> FrameRow:
    """Return the rows of a camera's frame, with the identities of the rig."""
    rows = [
        Track(
            report.frame, report.time, Ellipse.from_box(each.box), confidence=each.confidence,
            status=each.status, identity=identities[each.identity], label=each.label,
            occluded_by=identities.get(each.occluded_by or 0), further={"camera": report.camera},
            bounds=each.box,
        )
        for each in report.sightings
        if each.identity in identities
    ]  # fmt: skip
    return FrameRow(report.frame, report.time, tuple(rows))


def _target(path: Path) -> KnownTarget:
    try:
        return KnownTarget.load(path)
    except FormatError as error:
        raise SourceError(str(error)) from None


def _check(camera: Camera) -> None:
    """Raise a MotesError with the camera's name if its preset, detector or file is not usable."""
    try:
        WatchConfig.of(camera.preset or PRESET).changed({}, detector=camera.detector)
        named_detector(camera.detector)
        if is_recorded(camera.source):  # what is live may answer later
            open_source(camera.source, fps=camera.fps).close()
    except MotesError as error:
        raise type(error)(f"camera {camera.name}: {error}") from None


def watch_rig(
    file: str,
    output: str | None,
    overwrite: bool,
    seed: int,
    histogram: Path | None,
    *,
    own_code: bool = False,
) -> int:
    """Watch the cameras of a rig, write their rows and print a summary; return the exit code."""
    target = None if histogram is None else _target(histogram)
    rig = Rig.load(file)
    for camera in rig.camera:
        check_code(camera.detector, own_code)
        _check(camera)
    output = default_output(file) if output is None else output
    if output != "-":
        for source in (file, *(camera.source for camera in rig.camera)):
            check_not_source(source, Path(output))
        if Path(output).suffix.lower() not in FORMS:
            raise ConfigError(
                f"{output} ends neither in .csv nor in .jsonl, the forms for several cameras; "
                f"rename it."
            )
    rows = TrackWriter(output, overwrite=overwrite, further=["camera"])
    frames = dict.fromkeys((camera.name for camera in rig.camera), 0)
    dropped, found, failures = 0, set[int](), list[str]()
    interrupted: KeyboardInterrupt | None = None
    with contextlib.ExitStack() as opened:
        opened.enter_context(rows)
        try:
            with interrupts.deferred():
                watching = opened.enter_context(RigRunner(rig, seed, target))
            for news in watching:
                interrupts.check()
                with interrupts.deferred():
                    if isinstance(news, tuple):
                        report, identities = news
                        rows.add(frame_row(report, identities))
                        frames[report.camera] += 1
                        found.update(identities.values())
                    elif isinstance(news, CameraMessage):
                        log(f"camera {news.camera}: {news.text}")
                    else:
                        dropped += news.dropped
                        if news.failure is not None:
                            failures.append(f"camera {news.camera}: {news.failure}")
                            log(failures[-1])
        except KeyboardInterrupt as interrupt:
            interrupted = interrupt  # and all processes are ended as at the end
    if len(failures) == len(frames):
        raise SourceError(f"No camera is left. {failures[-1]}")
    merged = watching.handover.merged
    found -= merged.keys()
    read = ", ".join(f"{name} {count}" for name, count in frames.items())
    log(
        interrupts.word(interrupted)
        + f"{read} frames; {counted(len(found), 'object')}, "
        + f"{counted(watching.handover.handed, 'time')} handed over"
        + f", {dropped} frames dropped" * bool(dropped)
        + f"; wrote {output}." * (output != "-")
    )
    for gone, kept in merged.items():
        log(f"identity {gone} turned out to be {kept}, and is {kept} from then on.")
    if interrupted:
        return interrupts.code(interrupted)
    if failures:
        return PARTIAL
    if not found:
        what = "No object was ever found; try another detector."
        if target is not None:
            what = "The target was never found; check the histogram and the places."
        log(f"error: {what}")
    return DONE if found else NOT_FOUND
