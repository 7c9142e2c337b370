"""Models in ONNX files, run by ONNX Runtime, which also says what they take and give."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from numpy.typing import NDArray

from motes.core.callables import optional
from motes.core.errors import ConfigError, SourceError

Arrays: TypeAlias = dict[str, NDArray[Any]]
"""A model's inputs or outputs by name."""

LARGEST = 2**30
"""Bytes of the largest file. Running one takes three times as much memory, and no network of this
size keeps up with a film on a processor. (A protocol buffer could have twice as many.)"""
TYPES = {"float": "float32", "double": "float64"}
"""The names of numpy's types by those of ONNX Runtime, where they differ."""


class Tensor(NamedTuple):
    """An input or an output of a model."""

    name: str
    type: str
    """Its name, and the type of its numbers, such as float32."""
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


_WEIGHTS_FOLDER = "session.model_external_initializers_file_folder_path"


class Session:
    """A model that is ready to run. It may be used by several threads.

    Raises a MissingDependencyError if ONNX Runtime is not installed; a SourceError if the file is
    not there, too large, cut off or no ONNX file, or if a file with its weights is missing, or it
    holds operations that cannot be run; and a ConfigError if there is no such provider. `threads`
    is None for one on each core, and `provider` what ONNX Runtime runs it on, such as
    CUDAExecutionProvider, None for the processor. With `open_sizes` it takes inputs of other sizes
    than the file fixes. `inputs` and `outputs` are what the model takes and gives, and `metadata`
    the texts in the file, by name.
    """

    def __init__(
        self,
        path: str,
        threads: int | None = 1,
        provider: str | None = None,
        *,
        open_sizes: bool = False,
    ) -> None:
        _check_size(path)
        runtime = optional("onnxruntime", "ONNX files need ONNX Runtime", "motes[onnx]")
        known = runtime.get_available_providers()
        if provider is not None and provider not in known:
            raise ConfigError(
                f"There is no provider {provider!r}; this ONNX Runtime has {', '.join(known)}."
            )
        options = runtime.SessionOptions()
        options.log_severity_level = 4  # its warnings are not for users
        options.inter_op_num_threads = 1
        if threads is not None:
            options.intra_op_num_threads = threads
        # A model that is no file has its weights there.
        options.add_session_config_entry(_WEIGHTS_FOLDER, str(Path(path).absolute().parent))
        try:
            model = with_open_sizes(Path(path).read_bytes()) if open_sizes else path
            self._session = runtime.InferenceSession(
                model, options, providers=[provider or "CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime has errors of many kinds
            raise SourceError(_why_not_read(path, error, runtime.__version__)) from None
        self.path = path
        self.inputs = _tensors(self._session.get_inputs())
        self.outputs = _tensors(self._session.get_outputs())
        self.metadata: Mapping[str, str] = self._session.get_modelmeta().custom_metadata_map
        self._names = [each.name for each in self.outputs]

    def __str__(self) -> str:
        takes, gives = (", ".join(map(str, each)) for each in (self.inputs, self.outputs))
        return f"{Path(self.path).name} (takes {takes or 'nothing'}; gives {gives or 'nothing'})"

    def run(self, inputs: Mapping[str, NDArray[Any]]) -> Arrays:
        """Return all outputs by name, in arrays of their own.

        Raises a SourceError if the model does not run with these inputs.
        """
        try:
            return dict(zip(self._names, self._session.run(self._names, inputs), strict=True))
        except Exception as error:  # onnxruntime has errors of many kinds
            raise SourceError(f"{self.path} does not run: {one_line(error)}") from None


def _check_size(path: str) -> None:
    """Raise a SourceError unless there is a file of a size that a model may have."""
    try:
        if not Path(path).is_file():
            raise SourceError(f"There is no file {path}; check the name.")
        size = Path(path).stat().st_size
        Path(path).open("rb").close()
    except (OSError, ValueError) as error:  # a ValueError for a name with NUL
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SourceError(f"{path} cannot be read: {reason}; check the file.") from None
    if size > LARGEST:
        raise SourceError(
            f"{path} has {size / 2**30:.1f} GB; motes runs networks of up to 1 GB. Check the "
            f"name, or choose a smaller network."
        )
    if not size:
        raise SourceError(f"{path} is empty; copy or export it again.")


def _tensors(nodes: Sequence[Any]) -> tuple[Tensor, ...]:
    """Return inputs or outputs of ONNX Runtime."""
    found = []
    for node in nodes:
        kind = node.type.removeprefix("tensor(").removesuffix(")")
        shape = (side if isinstance(side, int) else None for side in node.shape)
        found.append(Tensor(node.name, TYPES.get(kind, kind), tuple(shape)))
    return tuple(found)


_DAMAGED = "Protobuf parsing failed", "No graph was found"
_MISSING = re.compile(r'External data path does not exist: "(?:.*[/\\])?(.*?)"')
_PLACES = re.compile(
    r"\[ONNXRuntimeError\] : \d+ : \w+ : |Load model from .*? failed:|/\S+:\d+ .*?\) "
)
"""What ONNX Runtime says of itself: its own codes, and the places and functions of its source."""


def _why_not_read(path: str, error: Exception, version: str) -> str:
    """Return why ONNX Runtime cannot read a file, and what to do."""
    text = str(error)
    if any(sign in text for sign in _DAMAGED):
        return f"{path} is cut off or no ONNX file; copy or export it again."
    if missing := _MISSING.search(text):
        return (
            f"{path} has its weights in {missing[1]}, which is not there; copy it beside the file."
        )
    return (
        f"{path} cannot be read as ONNX: {one_line(error)} Export it again, for ONNX Runtime "
        f"{version}."
    )


def one_line(error: Exception) -> str:
    """Return an error of another library in one line."""
    return _PLACES.sub("", " ".join(str(error).split()))[:300].rstrip(".") + "."


_FIXED_SIDES = ({7}, {11, 12, 13}, {2}, {1}, {2}, {1}, {1})
"""Where ONNX's protocol buffer has a side that is fixed: in the graph, in its inputs, outputs and
values between, in the type, the tensor, the shape and the dimension, `dim_value`."""
_UNKNOWN_FIELD = 15 << 3
"""The tag of a number that ONNX does not know, and skips."""


def with_open_sizes(model: bytes) -> bytes:
    """Return a model that fixes no side of its inputs, outputs and values between."""
    opened = bytearray(model)
    for place in _tags(model, _FIXED_SIDES, 0, len(model)):
        opened[place] = _UNKNOWN_FIELD
    return bytes(opened)


def _tags(data: bytes, path: Sequence[set[int]], start: int, end: int) -> Iterator[int]:
    """Yield where the fields at the end of a path of field numbers stand in a message."""
    while start < end:
        tag = start
        key, start = _varint(data, start)
        number, after = _varint(data, start) if key & 7 in (0, 2) else (0, start)
        if key & 7 == 2:  # a text or a message, after its length
            start, after = after, after + number
        elif key & 7 in (1, 5):
            after = start + (8 if key & 7 == 1 else 4)
        if key >> 3 in path[0]:
            yield from [tag] if len(path) == 1 else _tags(data, path[1:], start, after)
        start = after


def _varint(data: bytes, place: int) -> tuple[int, int]:
    """Return a whole number and the place after it."""
    number = shift = 0
    while True:
        number |= (data[place] & 127) << shift
        place, shift = place + 1, shift + 7
        if data[place - 1] < 128:
            return number, place
