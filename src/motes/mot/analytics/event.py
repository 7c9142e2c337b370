"""An event: something that an object does."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import msgspec

from motes.core.track import ROUNDING

Kind: TypeAlias = Literal["appears", "disappears", "crosses", "enters", "stays", "leaves"]


class Event(msgspec.Struct, frozen=True, rename={"identity": "id"}):
    """Something that an object does."""

    frame: int
    time: float
    """Index of the frame, and its time in seconds."""
    event: Kind
    """The kind of event."""
    identity: int
    """The object's; in JSON the key is `id`, as in rows."""
    x: float
    y: float
    """The place of its foot, the middle of its box's lower edge; of a crossing, on the line."""
    speed: float | None
    """In pixels a second, over the last half second in which it was seen whole; None before."""
    place: str | None = None
    direction: str | None = None
    """The name of the line or zone, and the line's label for the side to which it is crossed."""
    seconds: float | None = None
    """How long it has been in the zone where it stays or that it leaves, or in the picture."""
    metres_per_second: float | None = None
    """The speed on the ground, if that is known."""
    label: str | None = None
    """The object's class so far, if the detector knows classes."""

    @property
    def total(self) -> str:
        """The name of what it is counted as, such as `line 1 left`; without a place, its kind."""
        what = self.direction or self.event
        return what if self.place is None else f"{self.place} {what}"

    def fields(self) -> dict[str, Any]:
        """Return its fields by their names in JSON, with numbers rounded, without empty ones."""
        pairs = zip(self.__struct_encode_fields__, msgspec.structs.astuple(self), strict=True)
        return {key: _rounded(key, value) for key, value in pairs if value is not None}

    def json(self) -> str:
        """Return a line of JSON."""
        return msgspec.json.encode(self.fields()).decode()


def _rounded(name: str, value: Any) -> Any:
    """Return a number to three digits after the point; small speeds on the ground have five."""
    if not isinstance(value, float):
        return value
    small = name == "metres_per_second" and ROUNDING < value < 1e-2  # as under a microscope
    return float(f"{value:.5g}") if small else round(value, 3)
