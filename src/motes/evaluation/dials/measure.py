"""Runs of trackers over films of all dials and levels, seed by seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from motes.core.types import Floats
from motes.evaluation.adapters.registry import TrackerSpec
from motes.evaluation.datasets.sot import Problem, load_dataset
from motes.evaluation.finished_passes import finished_passes
from motes.evaluation.report.sections import problems as failed_passes
from motes.evaluation.scores import Outcome
from motes.evaluation.synthetic.dial_clips import clip_name, dial_clips, write_clip
from motes.evaluation.synthetic.scenes import Material


@dataclass(frozen=True)
class Plan:
    """What is measured.

    Attributes
    ----------
    trackers
        The trackers.
    dials, levels
        The dials, and the levels at which each is set; the first level is 0.
    seeds
        Number of scenes; each tracker runs once over each film.
    frames
        Length of a film.
    """

    trackers: tuple[TrackerSpec, ...]
    dials: tuple[str, ...]
    levels: tuple[float, ...]
    seeds: int
    frames: int


@dataclass(frozen=True)
class Measured:
    """The results so far.

    Attributes
    ----------
    plan
        What is measured.
    aucs
        The AUC of each tracker by the name of the film.
    done
        Number of seeds that are done.
    problems
        Failures.
    progress
        What was done last.
    """

    plan: Plan
    aucs: dict[str, dict[str, float]] = field(default_factory=dict)
    done: int = 0
    problems: tuple[Problem, ...] = ()
    progress: str = ""

    def of(self, tracker: str, dial: str, level: float) -> Floats:
        """Return the AUC of each seed that is done, (seeds,); NaN where a run failed."""
        found = self.aucs.get(tracker, {})
        names = (clip_name(dial, level, seed) for seed in range(self.done))
        return np.array([found.get(name, np.nan) for name in names])

    def hard(self, tracker: str, dial: str) -> Floats:
        """Return the mean AUC over the levels above 0 of each seed, (seeds,)."""
        levels = [level for level in self.plan.levels if level]
        means: Floats = np.mean([self.of(tracker, dial, level) for level in levels], axis=0)
        return means


def measured(
    plan: Plan, material: Material, workers: int, films: Path | None = None
) -> Iterator[Measured]:
    """Render films and run trackers over them; yield the results after each step.

    Parameters
    ----------
    plan
        What is measured.
    material
        What the films are made of.
    workers
        Number of processes.
    films
        A folder for the films, which are kept there; None to keep none.

    Raises
    ------
    FormatError
        If a film cannot be written.
    """
    outcomes: list[Outcome] = []
    now = Measured(plan)
    for seed in range(plan.seeds):
        with TemporaryDirectory(prefix="motes-") as scratch:
            folder, names = films or Path(scratch), set()
            clips = dial_clips(plan.dials, plan.levels, [seed], material, frames=plan.frames)
            for clip in clips:
                write_clip(clip, folder)
                names.add(clip.name)
                yield _after(now, f"rendered {clip.name}")
            found = [film for film in load_dataset(folder)[0] if film.name in names]
            ended: list[Outcome] = []
            for step in finished_passes(plan.trackers, found, 1, workers):
                ended = step.outcomes
                yield _after(now, f"scene {seed + 1} of {plan.seeds}, {step.progress}")
            outcomes += ended
        now = _result(plan, outcomes, seed + 1)
        yield now


def _after(now: Measured, progress: str) -> Measured:
    return Measured(now.plan, now.aucs, now.done, now.problems, progress)


def _result(plan: Plan, outcomes: Sequence[Outcome], done: int) -> Measured:
    aucs: dict[str, dict[str, float]] = {}
    for outcome in outcomes:
        if (auc := outcome.scores["auc"]) is not None:
            aucs.setdefault(outcome.item.tracker, {})[outcome.item.sequence] = float(auc)
    return Measured(plan, aucs, done, tuple(failed_passes((), outcomes)), f"{done} scenes")
