"""`motes track` frame by frame: one object, from the first frame on."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from motes.cli.frame_loop import exit_code, run, summarize
from motes.cli.known_run import remembered
from motes.cli.moment import Moments, Sink
from motes.cli.options import say_rate
from motes.cli.progress import RunStatistics
from motes.cli.track_loop import Begin, follow
from motes.cli.track_outputs import pictures_outputs
from motes.cli.track_request import TrackRequest
from motes.cli.track_units import check_size, measured, motion_names
from motes.cli.watch_outputs import format_of, rows_output
from motes.core.errors import ConfigError
from motes.mot.analytics.real_units import PIXELS
from motes.rows.schema import FORMS, GROUND
from motes.sot.particle_filter import ParticleFilter
from motes.sot.tracker import Tracker

if TYPE_CHECKING:
    from motes.video.sources import Source


def track_one(asked: TrackRequest, tracker: Tracker, begin: Begin) -> int:
    """Track one object; return the exit code.

    Raises
    ------
    ConfigError
        If an option makes no sense with the source or the output.
    """
    output, outputs, units = asked.output, asked.outputs, asked.units
    resume = outputs.resume
    form = None if output is None else format_of(output, outputs.format)
    if resume and form not in FORMS.values():
        raise ConfigError(f"--resume continues rows; {output} holds none, make it anew.")
    with asked.frames.open(asked.source) as film:
        if resume and film.live:
            raise ConfigError(f"{film.name} is live and cannot be read again; omit --resume.")
        check_size(units, film)
        say_rate(film)
        opened = pictures_outputs(
            film,
            asked.source,
            output,
            outputs,
            units,
            config=tracker.config,
            stride=asked.frames.stride,
        )
        moments: Moments = partial(follow, tracker, begin)
        if motion_names(outputs.figures) or units is not None:
            moments = measured(units or PIXELS, moments)
        if output is not None:
            opened += remembered(
                output, outputs, film, asked.frames, tracker.config, asked.seed, asked.preset,
                units=units, resume=resume,
            )  # fmt: skip
            further = () if units is None else GROUND
            opened.append(rows_output(output, film, outputs, further=further, resume=resume))
        return _run(film, tracker, moments, opened, quiet=output == "-")


def _run(
    film: Source, tracker: Tracker, moments: Moments, outputs: Sequence[Sink], *, quiet: bool
) -> int:
    """Track the target through the film, write the outputs and print a summary."""
    chooses = isinstance(tracker.config, ParticleFilter) and tracker.config.budget is not None
    tally = RunStatistics(budget=chooses)

    def report(interrupted: KeyboardInterrupt | None) -> None:
        if tally.frames:
            summarize([str(tally)], film, outputs, interrupted)

    quiet = quiet and sys.stdout.isatty()
    interrupted = run(film, outputs, moments, tally.add, report, quiet=quiet)
    missing = "The target was never found; look for another one, or elsewhere."
    return exit_code(interrupted, bool(tally.found), missing)
