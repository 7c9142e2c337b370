"""Saved states: plain values and arrays behind a digest, which damage does not pass.

What passes was written by motes. Load only what you trust: a file that was made to harm may name
any configuration, and have numbers that no frame leaves.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Annotated, Any, get_args

import msgspec
import numpy as np
from msgspec import Meta

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse

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
"""What reading a state of another configuration may raise."""
HEAD = b"motes tracker %d\n"
"""The first line: the version of the format. The digest follows."""

Size = Annotated[int, Meta(ge=0)]


def sealed(version: int, plain: Mapping[str, Any]) -> bytes:
    """Return plain values and arrays as the content of a file."""
    data = msgspec.msgpack.encode(plain, enc_hook=pack)
    return HEAD % version + hashlib.sha256(data).digest() + data


def unsealed(version: int, content: bytes) -> dict[str, Any]:
    """Return what `sealed` took, with arrays as `pack` has packed them.

    Raises a ValueError if the content is damaged, of another version, or of another program.
    """
    head, line, rest = content.partition(b"\n")
    if not head.startswith(HEAD.partition(b"%")[0]) or not line:
        raise ValueError("is not a saved tracker, or of another version of motes")
    if head.removesuffix(b"\r") + line != HEAD % version:  # the digest says what else is changed
        raise ValueError("was saved by another version of motes; save it anew")
    size = hashlib.sha256().digest_size
    digest, data = rest[:size], rest[size:]
    if hashlib.sha256(data).digest() != digest:
        raise ValueError("is damaged; save it anew")
    plain: dict[str, Any] = msgspec.msgpack.decode(data)
    return plain


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
    """Return plain values in the types of fresh ones, which have the same keys.

    Raises a ValueError if they have other keys, or a value has another type; `name` is theirs in
    messages.
    """
    if list(values) != list(fresh):
        raise ValueError(f"{name} has {', '.join(values)}, not {', '.join(fresh)}")
    typed = dict[str, Any]()
    for key, value in values.items():
        try:
            typed[key] = msgspec.convert(value, type(fresh[key]), dec_hook=unpack)
        except msgspec.ValidationError as error:
            message, _, place = str(error).partition(" - at `$")
            raise ValueError(f"{message} - at `{name}.{key}{place or '`'}") from None
    return typed


def middle_of(frame: Frame, a: float, b: float) -> Ellipse:
    """Return an ellipse in the middle of a frame, from which models of any state are learned."""
    return Ellipse(frame.width / 2, frame.height / 2, a, b)
