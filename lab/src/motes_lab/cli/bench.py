"""`motes-lab bench`: the speed of trackers on this machine, side by side in one run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes import ConfigError, SourceError
from motes.cli import Whole, check_counts
from motes.core import read_text
from motes_lab.adapters.opencv import peer
from motes_lab.datasets.sot import Sequence as TrueSequence, load_dataset
from motes_lab.experiment import ResultOptions
from motes_lab.inputs import REPEATED, RUN
from motes_lab.speed import measure as speed, report as speed_report
from motes_lab.speed.parts import PARTS, Part, measured


def bench(
    *,
    part: Annotated[
        list[Part] | None,
        REPEATED,
        Parameter(group=RUN, help="Measure only this part; may be repeated. All by default."),
    ] = None,
    rounds: Annotated[Whole, Parameter(group=RUN, help="Number of measurements of each job.")] = 3,
    against: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            help="bench.md of another run; its ratios to the peers are compared with those of this "
            "run.",
        ),
    ] = None,
    data: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            env_var="MOTES_DATA",
            help=f"Folder with real sequences for another table: {', '.join(speed.SEQUENCES)}; "
            "its subfolder sot also serves.",
        ),
    ] = None,
    nano: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="ONNX files of NanoTrack, BACKBONE,HEAD; it then also runs on real sequences.",
        ),
    ] = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Measure trackers side by side.

    The parts are:

    - trackers: one update of each tracker and of OpenCV's, on rendered clips;
    - sequences: the same on real sequences, which --data names, in turn frame by frame.

    Each job runs once in every round. A time is the median over all updates; it is measured inside
    the tracker.
    """
    check_counts(rounds=rounds)
    wanted = set(part or PARTS)
    if against is not None and "trackers" not in wanted:
        raise ConfigError(
            "--against compares the part trackers; measure that too, or omit --against."
        )
    if data is None:
        if part and "sequences" in wanted:
            raise ConfigError("Real sequences are in a folder; give it with --data.")
        wanted.discard("sequences")
    stored = None if against is None else speed_report.stored_ratios(read_text(against), against)
    networks = []
    if nano is not None:
        if data is None:
            raise ConfigError("--nano needs real sequences; give their folder with --data.")
        networks = [f"cv2:nano={nano}"]
        peer(networks[0])  # refuses files that cannot be used
    sequences = [] if data is None or "sequences" not in wanted else _sequences(data)
    return results.show("bench", measured(wanted, rounds, stored, sequences, networks))


def _sequences(folder: Path) -> list[TrueSequence]:
    """Return the real sequences in a folder that are measured."""
    place = folder / "sot" if (folder / "sot").is_dir() else folder
    found, problems = load_dataset(place)
    chosen = [sequence for sequence in found if sequence.name in speed.SEQUENCES]
    if not chosen:
        known = ", ".join(speed.SEQUENCES)
        text = "; ".join(f"{problem.where}: {problem.what}" for problem in problems)
        raise SourceError(f"--data {folder} has none of the sequences {known}. {text}".strip())
    return chosen
