"""A known target: its histograms, in a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

import msgspec
import numpy as np
from msgspec import Meta

from motes.core.config import Config, Positive, from_dict, from_json
from motes.core.errors import ConfigError, FormatError
from motes.core.files import write_whole, writing
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.saved_state import ROUNDING, check
from motes.cues.base import CUES, AdaptableCue, Cue
from motes.cues.color import Color, ColorModel


class _Other(Config, frozen=True):
    """A cue other than color, and the target's model for it."""

    cue: dict[str, Any]
    model: dict[str, Any]


class _File(Config, frozen=True, tag="motes_histogram", omit_defaults=True):
    """The content of a histogram file.

    Color has pairs of bin number and share, without empty bins. Other cues have whole models.
    """

    a: Positive
    b: Positive
    theta: float
    cue: Color | None = None
    bins: tuple[tuple[int, Annotated[float, Meta(gt=0, le=1)]], ...] = ()
    others: dict[str, _Other] = {}  # noqa: RUF012  (msgspec copies it)


@dataclass(frozen=True, slots=True, eq=False)
class KnownTarget:
    """A target whose histograms are known before it is seen (Nummiaro et al., section V).

    Attributes
    ----------
    cues
        The cues that made the histograms, by name; a tracker that searches for the target needs
        the same ones.
    models
        The target's model for each cue.
    size
        An ellipse of the target's size, at the origin.
    """

    cues: Mapping[str, Cue]
    models: Mapping[str, Any]
    size: Ellipse

    @classmethod
    def learn(cls, cues: Color | Mapping[str, Cue], frame: Frame, region: Ellipse) -> Self:
        """Return the target in a region of a frame, by color alone or by the cues of a tracker.

        Raises
        ------
        ConfigError
            If a cue compares no histograms: what it learns is of one frame and its surroundings.
        """
        named = {"color": cues} if isinstance(cues, Color) else cues
        for name, cue in named.items():
            if not isinstance(cue, AdaptableCue):
                raise ConfigError(
                    f"A target cannot be known by {name}, which has no histogram; leave it out."
                )
        models = {name: cue.learn(frame, region) for name, cue in named.items()}
        return cls(named, models, region._replace(x=0.0, y=0.0))

    def models_for(self, cues: Mapping[str, Cue]) -> dict[str, Any]:
        """Return the models for the cues of a tracker, which must read as the target's do.

        They may differ in which pixels they read, and in the weights of these.

        Raises
        ------
        ConfigError
            If the tracker has other cues, or settings by which histograms cannot be compared.
        """
        if set(cues) != set(self.cues):
            raise ConfigError(
                f"The tracker compares {', '.join(cues)}, the known target has "
                f"{', '.join(self.cues)}; make its histogram with the tracker's preset."
            )
        for name, cue in cues.items():
            mine, its = _reading(cue), _reading(self.cues[name])
            for key in [key for key in mine if mine[key] != its.get(key)]:
                raise ConfigError(
                    f"The tracker's {name}.{key} is {mine[key]}, the histogram's {its.get(key)}; "
                    f"make it anew with the tracker's settings."
                )
        return {name: self.models[name] for name in cues}

    def save(self, path: str | Path) -> None:
        """Write the target as JSON.

        Raises
        ------
        FormatError
            If the file cannot be written.
        """
        color = self.cues.get("color")
        bins: tuple[tuple[int, float], ...] = ()
        if isinstance(color, Color):
            histogram = self.models["color"].histogram
            bins = tuple((int(u), float(histogram[u])) for u in np.flatnonzero(histogram))
        a, b, theta = (float(value) for value in self.size[2:])
        others = {
            name: _Other(msgspec.to_builtins(cue), _plain(self.models[name]))
            for name, cue in self.cues.items()
            if not isinstance(cue, Color)
        }
        file = _File(a, b, theta, color if isinstance(color, Color) else None, bins, others)
        with writing(path):
            write_whole(path, msgspec.json.format(msgspec.json.encode(file)) + b"\n")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a target that `save` wrote.

        Raises
        ------
        FormatError
            If the file is missing or is not a histogram file.
        """
        try:
            file: _File = from_dict(from_json(Path(path).read_bytes()), _File)
            others = {name: _other(name, other) for name, other in file.others.items()}
        except OSError as error:
            raise FormatError(f"Cannot read the histogram {path}: {error.strerror}.") from None
        except (ConfigError, ValueError) as error:
            raise FormatError(
                f"{path} is not a histogram file ({error}); make one with "
                f"motes track --save-histogram."
            ) from None
        cues: dict[str, Cue] = {name: cue for name, (cue, _) in others.items()}
        models = {name: model for name, (_, model) in others.items()}
        if file.cue is not None:
            histogram = np.zeros(file.cue.size)
            numbers = [number for number, _ in file.bins]
            if not numbers or not 0 <= min(numbers) <= max(numbers) < histogram.size:
                raise FormatError(f"{path}: bins must be 0 to {histogram.size - 1}, at least one.")
            histogram[numbers] = [share for _, share in file.bins]
            histogram /= histogram.sum()
            cues = {"color": file.cue} | cues
            models["color"] = ColorModel(histogram, histogram)
        if not cues:
            raise FormatError(
                f"{path} has no histogram; make one with motes track --save-histogram."
            )
        return cls(cues, models, Ellipse(0, 0, file.a, file.b, file.theta))


def _reading(cue: Cue) -> dict[str, Any]:
    """Return the settings of a cue on which the meaning of its bins depends."""
    values: dict[str, Any] = msgspec.structs.asdict(cue)  # type: ignore[arg-type]
    return {key: value for key, value in values.items() if key not in ("kernel", "sampling")}


def _plain(model: Any) -> dict[str, Any]:
    """Return a model as plain values, its arrays as lists."""
    values: dict[str, Any] = msgspec.to_builtins(model, enc_hook=lambda array: array.tolist())
    return values


def _other(name: str, other: _Other) -> tuple[Cue, Any]:
    """Return a cue other than color and its model; raise a ValueError if they do not fit."""
    cue: Cue = from_dict(other.cue, CUES.resolve(name))
    if not isinstance(cue, AdaptableCue):
        raise ValueError(f"{name} has no histogram")
    fresh = cue.learn(Frame(0, 0.0, np.zeros((32, 32, 3), np.uint8)), Ellipse(16, 16, 8, 8))
    try:
        model = msgspec.convert(
            other.model, type(fresh), dec_hook=lambda _, value: np.array(value, np.float64)
        )
    except (msgspec.ValidationError, OverflowError) as error:
        raise ValueError(f"{name}: {error}") from None
    check(model, fresh, name)
    if not min(abs(model.histogram.sum() - 1), model.histogram.sum()) < ROUNDING:
        raise ValueError(f"the shares of {name} do not sum to 1")
    return cue, model
