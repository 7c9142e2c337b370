"""What an ONNX file says of its model: inputs, outputs, metadata, and where its weights lie.

The few fields of ONNX's protocol buffer that this needs are read here; weights and operations are
skipped. So a damaged file is found before it is loaded.
"""

from __future__ import annotations

import mmap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import msgspec

from motes.core.errors import SourceError

LARGEST = 2**30
"""Bytes of the largest file. Running one takes three times as much memory, and no network of this
size keeps up with a film on a processor. (A protocol buffer could have twice as many.)"""
TYPES = {1: "float32", 2: "uint8", 3: "int8", 6: "int32", 7: "int64", 10: "float16", 11: "float64"}
"""The names of numpy's types by ONNX's numbers."""


class Tensor(NamedTuple):
    """An input or an output of a model."""

    name: str
    """Its name."""
    type: str
    """The type of its numbers, such as float32."""
    shape: tuple[int | None, ...]
    """Its sides; None for each one that the file leaves open."""

    def __str__(self) -> str:
        sides = "x".join("?" if side is None else str(side) for side in self.shape)
        return f"{self.name} {self.type} {sides}".strip()

    def holds(self, *shape: int) -> bool:
        """Return whether it takes numbers in single precision of this shape."""
        return (
            self.type == "float32"
            and len(self.shape) == len(shape)
            and all(own in (None, side) for own, side in zip(self.shape, shape, strict=True))
        )


class OnnxFile(msgspec.Struct, frozen=True):
    """A model in an ONNX file."""

    path: str
    """The file."""
    inputs: tuple[Tensor, ...]
    outputs: tuple[Tensor, ...]
    """What it takes and gives; values with weights are no inputs."""
    metadata: Mapping[str, str]
    """Texts by name."""
    dimensions: tuple[int, ...]
    """The places in the file of all sides that it fixes: of inputs, outputs and values between."""

    def __str__(self) -> str:
        takes, gives = (", ".join(map(str, each)) for each in (self.inputs, self.outputs))
        return f"{Path(self.path).name} (takes {takes or 'nothing'}; gives {gives or 'nothing'})"

    def open_sizes(self) -> bytes:
        """Return the model with every side left open, so that it takes pictures of other sizes.

        The number of each field `dim_value` becomes one that ONNX does not know, and skips.
        """
        data = bytearray(Path(self.path).read_bytes())
        for place in self.dimensions:
            data[place] = _UNKNOWN_FIELD
        return bytes(data)


_UNKNOWN_FIELD = 15 << 3


def read_onnx(path: str) -> OnnxFile:
    """Return what an ONNX file says of its model.

    Raises
    ------
    SourceError
        If the file is not there, cannot be read, is cut off or no ONNX file, or if a file with its
        weights is missing.
    """
    try:
        if not Path(path).is_file():
            raise SourceError(f"There is no file {path}; check the name.")
        size = Path(path).stat().st_size
        if size > LARGEST:
            raise SourceError(
                f"{path} has {size / 2**30:.1f} GB; motes runs networks of up to 1 GB. Check the "
                f"name, or choose a smaller network."
            )
        if not size:
            raise SourceError(f"{path} is empty; copy or export it again.")
        with (
            Path(path).open("rb") as file,
            mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data,
        ):
            return _model(path, data)
    except _DamagedError:
        raise SourceError(f"{path} is cut off or no ONNX file; copy or export it again.") from None
    except (OSError, ValueError) as error:  # a ValueError for a name with NUL
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SourceError(f"{path} cannot be read: {reason}; check the file.") from None


class _DamagedError(Exception):
    """The bytes are no such protocol buffer."""


class _Field(NamedTuple):
    """A field of a protocol buffer: where its tag stands, its whole number, or where it lies."""

    key: int
    tag: int
    number: int
    start: int
    end: int


def _varint(data: mmap.mmap, place: int, end: int) -> tuple[int, int]:
    """Return a whole number and the place after it."""
    number = 0
    for shift in range(0, 70, 7):
        if place >= end:
            break
        byte = data[place]
        number |= (byte & 127) << shift
        place += 1
        if byte < 128:
            return number, place
    raise _DamagedError


def _fields(data: mmap.mmap, start: int, end: int) -> Iterator[_Field]:
    """Yield the fields of a message."""
    while start < end:
        tag = start
        key, start = _varint(data, start, end)
        number, kind = 0, key & 7
        if kind == 0:
            number, after = _varint(data, start, end)
        elif kind == 2:
            length, start = _varint(data, start, end)
            after = start + length
        elif kind in (1, 5):
            after = start + (8 if kind == 1 else 4)
        else:
            raise _DamagedError
        if after > end or key < 8:
            raise _DamagedError
        yield _Field(key >> 3, tag, number, start, after)
        start = after


def _text(data: mmap.mmap, field: _Field) -> str:
    return data[field.start : field.end].decode(errors="replace")


def _pair(data: mmap.mmap, entry: _Field) -> tuple[str, str]:
    """Return a name and its text."""
    values = {field.key: _text(data, field) for field in _fields(data, entry.start, entry.end)}
    return values.get(1, ""), values.get(2, "")


def _model(path: str, data: mmap.mmap) -> OnnxFile:
    metadata: dict[str, str] = {}
    graph = None
    for field in _fields(data, 0, len(data)):
        if field.key == 7:
            graph = field
        elif field.key == 14:
            metadata |= [_pair(data, field)]
    if graph is None:
        raise _DamagedError
    inputs: list[Tensor] = []
    outputs: list[Tensor] = []
    weights, dimensions = set[str](), list[int]()
    for field in _fields(data, graph.start, graph.end):
        if field.key == 5:
            weights.add(_weights(path, data, field))
        elif field.key in (11, 12, 13):
            tensor, places = _value(data, field)
            dimensions += places
            if field.key != 13:
                (inputs if field.key == 11 else outputs).append(tensor)
    given = tuple(each for each in inputs if each.name not in weights)
    return OnnxFile(path, given, tuple(outputs), metadata, tuple(dimensions))


def _weights(path: str, data: mmap.mmap, tensor: _Field) -> str:
    """Return the name of weights; raise a SourceError if they are missing beside the file."""
    name, outside = "", ""
    for field in _fields(data, tensor.start, tensor.end):
        if field.key == 8:
            name = _text(data, field)
        elif field.key == 13:
            key, value = _pair(data, field)
            outside = value if key == "location" else outside
    if outside and not (Path(path).parent / outside).is_file():
        raise SourceError(
            f"{path} has its weights in {outside}, which is not there; copy it beside the file."
        )
    return name


def _value(data: mmap.mmap, value: _Field) -> tuple[Tensor, list[int]]:
    """Return an input, an output or a value between, and where its sides stand."""
    name, kind, places = "", 0, []
    shape: list[int | None] = []
    for field in _fields(data, value.start, value.end):
        if field.key == 1:
            name = _text(data, field)
        for tensor in _fields(data, field.start, field.end) if field.key == 2 else ():
            for part in _fields(data, tensor.start, tensor.end) if tensor.key == 1 else ():
                if part.key == 1:
                    kind = part.number
                for side in _fields(data, part.start, part.end) if part.key == 2 else ():
                    shape.append(None)
                    for entry in _fields(data, side.start, side.end):
                        if entry.key == 1:
                            shape[-1] = entry.number
                            places.append(entry.tag)
    return Tensor(name, TYPES.get(kind, f"type {kind}"), tuple(shape)), places
