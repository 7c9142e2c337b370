"""From the names of trackers to those that take part in an evaluation.

A name of a tracker of one object is one of these:

| name | meaning |
|---|---|
| `nummiaro`, `mean_shift` … | a preset of motes |
| `default:network=FILE,FILE` | the default tracker with a trained network |
| `PATH.toml` | a configuration; its key `preset` names the base, else `nummiaro` |
| `cv2:csrt` … | a tracker of OpenCV (`opencv.PEERS`) |
| `cv2:nano=BACKBONE,HEAD` | NanoTrack of OpenCV, with its two ONNX files |
| `cv2:vit=NETWORK` | VitTrack of OpenCV, with its ONNX file |
| `module:factory` | a Python callable |

The callable is called without arguments, or with `seed=` if it has a parameter of this name; it is
then run once for each seed. It returns an object with `init(image, box)` and `update(image)`, which
is used for one start only. Images are RGB uint8 (H, W, 3), the box is x, y, width, height, 0-based.
`update` returns a region, or `(found, region)`, or a `motes.Track`, or None if it has lost the
target; a region is a box or an ellipse x, y, a, b, theta. Modules are also searched in the current
folder.

A name of a tracker of many objects is one of these:

| name | meaning |
|---|---|
| `motes:scene` | the `Scene` of motes, with its default values |
| `trackers:sort` … | a tracker of the package `trackers` (`mot.PEERS`) |
| `results=FOLDER` | saved results, a file SEQUENCE.txt for each sequence |
| `module:factory` | a Python callable |

This callable is called with an `adapters.mot.SequenceInfo`, and `seed=` as above. It returns an
object with `update(frame, detections)`: a `motes.Frame`, and a list of `motes.Detection`, or None
if the dataset has none. `update` returns a list of (id, box, confidence).
"""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import inspect
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

from motes import (
    PRESETS,
    ConfigError,
    Discriminative,
    MeanShift,
    MotesError,
    SourceError,
    TrackerConfig,
    __version__,
    configure,
    named_detector,
    preset,
    scene_config,
)
from motes.core import explain, from_toml, import_callable, read_text
from motes.sot import Network
from motes_lab.adapters import mot as mot
from motes_lab.adapters.networks import NETWORKS, network_files
from motes_lab.adapters.opencv import PEERS, STOCHASTIC, is_peer, opencv
from motes_lab.adapters.sot import CallableAdapter, MotesAdapter, OpenCVAdapter
from motes_lab.datasets.sot import Problem

JOINED = "default:network="
KNOWN = [*PRESETS, *PEERS, *NETWORKS]
"""Names of the trackers of one object that motes has or knows."""
KNOWN_MOT = [mot.SCENE, *mot.PEERS]
"""Names of the trackers of many objects that motes has or knows."""


@dataclass(frozen=True, slots=True)
class TrackerSpec:
    """A tracker that takes part in an evaluation; it can be sent to another process."""

    name: str
    """The name that the user gave."""
    configuration: str
    """A text; as long as it stays the same, so do the tracks."""
    stochastic: bool
    """Whether different seeds may give different tracks."""
    make: partial[Any]
    """Makes an adapter, with a seed if the tracker is stochastic."""

    def begin(self, seed: int) -> Any:
        """Return a new adapter."""
        return self.make(seed) if self.stochastic else self.make()


def resolve(
    names: Iterable[str], find: Callable[[str], TrackerSpec] | None = None
) -> tuple[list[TrackerSpec], list[Problem]]:
    """Return the trackers of these names, each once, and the problems of the others.

    `find` returns the tracker of a name; by default it is `tracker_spec`.
    """
    specs: list[TrackerSpec] = []
    problems: list[Problem] = []
    for name in dict.fromkeys(names):
        try:
            specs.append((find or tracker_spec)(name))
        except MotesError as error:
            problems.append(Problem(f"tracker {name}", str(error)))
    return specs, problems


def tracker_spec(name: str) -> TrackerSpec:
    """Return the tracker of a name.

    Raises
    ------
    ConfigError
        If there is none, or its configuration or callable is not valid.
    SourceError
        If its configuration cannot be read.
    MissingDependencyError
        If its package is not installed.
    """
    if name in PRESETS or name.endswith(".toml"):
        return _motes_spec(name, motes_config(name))
    if is_peer(name):
        version = f"OpenCV {opencv(name).__version__}"
        for file in network_files(name):
            version += f" {hashlib.sha256(file.read_bytes()).hexdigest()}"
        return TrackerSpec(name, version, name in STOCHASTIC, partial(OpenCVAdapter, name))
    kind, colon, rest = name.partition(":")
    if name.startswith(JOINED):
        network = Network(tuple(name.removeprefix(JOINED).split(",")))
        network.open()
        return _motes_spec(name, Discriminative(network=network))
    if name in KNOWN_MOT:
        raise ConfigError("It follows many objects, and this dataset has one.")
    if colon and rest and kind != "cv2":
        return _callable_spec(name, CallableAdapter, KNOWN)
    raise ConfigError(f"There is no tracker of this name; {_hint(name, KNOWN)}")


def mot_tracker_spec(name: str) -> TrackerSpec:
    """Return the tracker of many objects of a name.

    Raises
    ------
    ConfigError, SourceError, MissingDependencyError
        As `tracker_spec`.
    """
    kind, colon, rest = name.partition(":")
    if name == mot.SCENE:
        return TrackerSpec(name, scene_config().to_toml(), True, partial(mot.SceneAdapter))
    if name in mot.PEERS:
        mot.import_peers(name)
        version = f"trackers {metadata.version('trackers')}"
        return TrackerSpec(name, version, False, partial(mot.AssociationAdapter, name))
    if name.startswith("results="):
        return _results_spec(name, Path(name.removeprefix("results=")))
    if colon and rest and kind not in ("motes", "trackers"):
        return _callable_spec(name, mot.CallableMotAdapter, KNOWN_MOT)
    raise ConfigError(
        f"There is no tracker of this name for many objects; {_hint(name, KNOWN_MOT)}"
    )


def with_detector(specs: Iterable[TrackerSpec], detector: str) -> list[TrackerSpec]:
    """Return trackers of many objects that use a detector instead of the dataset's detections.

    Parameters
    ----------
    specs
        The trackers; saved results are not changed.
    detector
        `background`; an ONNX file; or `module:callable`, a `motes.Detector` or a callable without
        arguments that makes one.

    Raises
    ------
    ConfigError
        If there is none, or its callable is not valid.
    SourceError
        If the ONNX file cannot be read.
    MissingDependencyError
        If its package is not installed.
    """
    if detector == mot.BACKGROUND:
        found = f"{detector}, motes {__version__}"
    elif detector.endswith(".onnx"):
        named_detector(detector)
        found = f"{detector} {hashlib.sha256(Path(detector).read_bytes()).hexdigest()}"
    elif not all(detector.partition(":")):
        raise ConfigError(
            f"There is no detector {detector}; give {mot.BACKGROUND}, MODULE:NAME or an .onnx file."
        )
    else:
        try:
            found, _ = _import_callable(detector, [mot.BACKGROUND])
        except ConfigError as error:
            raise ConfigError(f"The detector {detector}: {error}") from None
    return [
        entry
        if entry.make.func is mot.SavedResultsAdapter
        else replace(
            entry,
            configuration=f"{entry.configuration}; {found}",
            make=partial(mot.DetectorAdapter, detector, entry.make),
        )
        for entry in specs
    ]


def _results_spec(name: str, folder: Path) -> TrackerSpec:
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix == ".txt")
        texts = [path.name.encode() + b"\0" + path.read_bytes() for path in files]
    except OSError as error:
        raise SourceError(f"{error.filename} cannot be read: {error.strerror}.") from None
    if not texts:
        raise SourceError(f"There is no text file in {folder}; it has one for each sequence.")
    digest = hashlib.sha256(b"\0".join(texts)).hexdigest()
    return TrackerSpec(name, digest, False, partial(mot.SavedResultsAdapter, folder.resolve()))


def _hint(name: str, known: list[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}."


def _motes_spec(name: str, config: TrackerConfig) -> TrackerSpec:
    return TrackerSpec(
        name, config.to_toml(), not isinstance(config, MeanShift), partial(MotesAdapter, config)
    )


def motes_config(name: str) -> TrackerConfig:
    """Return the configuration of a preset or of a TOML file; raise as `tracker_spec` does."""
    if not name.endswith(".toml"):
        return preset(name)
    values = from_toml(read_text(name), "this file")
    base = values.pop("preset", "nummiaro")
    if not isinstance(base, str):
        raise ConfigError(f"preset is {base!r}; give the name of one, such as 'nummiaro'.")
    return configure(preset(base), values)


def _callable_spec(
    name: str, kind: type[CallableAdapter | mot.CallableMotAdapter], known: list[str]
) -> TrackerSpec:
    configuration, seeded = _import_callable(name, known)
    return TrackerSpec(name, configuration, seeded, partial(kind, name))


def _import_callable(name: str, known: list[str]) -> tuple[str, bool]:
    """Return a text that changes when a callable's module does, and whether it takes a seed."""
    module = name.partition(":")[0]
    try:
        with contextlib.redirect_stdout(sys.stderr):  # standard output is for results
            seeded = "seed" in inspect.signature(import_callable(name)).parameters
        # The module's text is included, so that a changed tracker has another configuration.
        source = getattr(sys.modules[module], "__file__", None)
        digest = hashlib.sha256(Path(source).read_bytes()).hexdigest() if source else ""
    except ModuleNotFoundError as error:
        if error.name != module.partition(".")[0]:
            raise ConfigError(f"It cannot be imported: {error}; install it.") from None
        raise ConfigError(
            f"There is neither such a name here nor a module {error.name}; {_hint(name, known)}"
        ) from None
    except ConfigError:
        raise
    except (Exception, SystemExit) as error:  # importing a module may raise anything
        raise ConfigError(f"It cannot be imported: {explain(error)}; correct it.") from None
    return f"{name} {digest}".strip(), seeded
