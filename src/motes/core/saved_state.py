"""Checks of a tracker's saved state: kernels use its numbers as indices, without checks.

A configuration makes a fresh state for the saved frame. The saved state must have the same types
and keys, and arrays of the same types and shapes. Its numbers must be finite and no larger than
`LARGEST`. Other limits stand at the declarations of the fields: `Annotated` with an `Array` or with
`SAME`.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Annotated, Any, Final, NamedTuple, get_args, get_type_hints

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import ArrayLike, NDArray

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles

LARGEST = 1e12
"""Largest number in a state: its square, its products and its rounding do not overflow."""
UNREADABLE = (
    msgspec.MsgspecError,
    MotesError,
    TypeError,
    ValueError,
    LookupError,
    OverflowError,
    RecursionError,
    MemoryError,
)
"""What reading other bytes may raise: wrong types, deep nesting, sizes that are too large."""
LEAST_HALF = 0.5
"""Least half-axis of an ellipse, in pixels; that of motion models and regions is 1, rounded."""


ROUNDING = 1e-6
"""Largest error of a sum by rounding."""


class Array(NamedTuple):
    """The limits of an array's numbers."""

    least: float | tuple[float, ...] = -LARGEST
    """Least number: of the whole array, or of each column."""
    total: float | None = None
    """The sum of all numbers; None for any sum."""


SAME: Final = "same"
"""Marks a number that follows from the rest of a state: it must be that of the fresh state."""
ELLIPSES = Array(least=(-LARGEST, -LARGEST, LEAST_HALF, LEAST_HALF, -LARGEST))
"""Marks ellipses (N, 5): x, y, a, b, theta."""
NotNegative = Annotated[Floats, Array(least=0.0)]
NotNegativeSingles = Annotated[Singles, Array(least=0.0)]


Size = Annotated[int, Meta(ge=0)]


def pack(value: Any) -> Any:
    """Return an array as [dtype, shape, bytes]: the hook of a msgspec encoder."""
    return [value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes()]


def unpack(kind: Any, value: Any) -> Any:
    """Return an array that `pack` wrote, of the type of its field: the hook of a decoder."""
    dtype = np.dtype(get_args(get_args(kind)[1])[0])
    name, shape, data = msgspec.convert(value, tuple[str, tuple[Size, ...], bytes])
    if name != dtype.str:
        raise ValueError(f"an array is {name}, not {dtype.str}")
    return np.frombuffer(data, dtype).reshape(shape).copy()


def in_types_of(fresh: Mapping[str, Any], values: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return plain values in the types of fresh ones with the same keys; others stay plain.

    `name` names them in errors.
    """
    typed = dict(values)
    for key in filter(fresh.__contains__, values):
        try:
            typed[key] = msgspec.convert(values[key], type(fresh[key]), dec_hook=unpack)
        except msgspec.ValidationError as error:
            message, _, place = str(error).partition(" - at `$")
            raise ValueError(f"{message} - at `{name}.{key}{place or '`'}") from None
    return typed


def check(value: Any, fresh: Any, name: str, mark: object = None) -> None:
    """Check a state, or a part of one.

    Parameters
    ----------
    value, fresh
        The part, and the same one of a fresh state.
    name
        Its name in errors.
    mark
        The annotation of its field.

    Raises
    ------
    ValueError
        If it is not like the fresh one; the message names the part that is not.
    """
    if value is None or isinstance(value, bool | enum.Enum):
        return  # the type of plain values is right already
    if isinstance(value, int | float):
        if mark == SAME and value != fresh:
            raise ValueError(f"{name} is {value:g}; {fresh:g} follows from the rest")
        # Whole numbers count something.
        if not (0 if isinstance(value, int) else -LARGEST) <= value <= LARGEST:
            raise ValueError(f"{name} is {value:g}")
    elif type(value) is not type(fresh):
        raise ValueError(f"{name} is a {type(value).__name__}, not a {type(fresh).__name__}")
    elif isinstance(value, np.ndarray):
        if (value.dtype, value.shape) != (fresh.dtype, fresh.shape):
            raise ValueError(
                f"{name} is {value.dtype} of shape {value.shape}, not {fresh.dtype} of shape "
                f"{fresh.shape}"
            )
        check_numbers(value, name, mark if isinstance(mark, Array) else Array())
    elif isinstance(value, Ellipse):
        check_numbers(np.array(value), name, ELLIPSES)
    elif isinstance(value, dict):
        if list(value) != list(fresh):
            raise ValueError(f"{name} has {', '.join(value)}, not {', '.join(fresh)}")
        for key in value:
            check(value[key], fresh[key], f"{name}.{key}")
    elif type(value) is tuple:
        for number in value:
            check(number, number, name)
    else:
        for field, own in _marks(type(value)).items():
            check(getattr(value, field), getattr(fresh, field), f"{name}.{field}", own)


def check_numbers(array: NDArray[Any], name: str, numbers: Array) -> None:
    """Raise a ValueError if numbers are outside their limits."""
    parts = array.ravel().view(array.real.dtype) if np.iscomplexobj(array) else array
    wrong = ~((parts >= np.array(numbers.least)) & (parts <= LARGEST))  # NaN is wrong
    if wrong.any():
        raise ValueError(f"{name} holds {parts[wrong][0]:g}")
    if numbers.total is not None and abs(parts.sum() - numbers.total) > ROUNDING:
        raise ValueError(f"{name} sums to {parts.sum():g}, not {numbers.total:g}")


def rows(row: ArrayLike, like: NDArray[Any]) -> Floats:
    """Return equal rows, as many as `like` has and at least one; they need no memory."""
    return np.broadcast_to(row, (max(len(like), 1), *np.shape(row)))


def middle_of(frame: Frame, a: float, b: float) -> Ellipse:
    """Return an ellipse in the middle of a frame, for a fresh state.

    Raises
    ------
    ValueError
        If a region of the frame cannot have these half-axes.
    """
    if not LEAST_HALF <= min(a, b) <= max(a, b) <= frame.width + frame.height:
        raise ValueError(f"a target of {2 * a:g}x{2 * b:g} pixels does not fit into the frame")
    return Ellipse(frame.width / 2, frame.height / 2, a, b)


def _marks(kind: type) -> dict[str, object]:
    """Return the fields of a type, with what they are annotated with, if anything."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: (*getattr(hint, "__metadata__", ()), None)[0] for name, hint in hints.items()}
