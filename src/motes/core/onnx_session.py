"""Models in ONNX files, run by ONNX Runtime."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from numpy.typing import NDArray

from motes.core.errors import ConfigError, SourceError
from motes.core.onnx_file import OnnxFile, read_onnx
from motes.core.optional import optional

Arrays: TypeAlias = dict[str, NDArray[Any]]
"""A model's inputs or outputs by name."""


def open_session(
    path: str, threads: int | None = 1, provider: str | None = None, *, open_sizes: bool = False
) -> Session:
    """Return the model in an ONNX file, ready to run.

    Parameters
    ----------
    path
        The file.
    threads
        Number of threads; None for one on each core.
    provider
        What ONNX Runtime runs it on, such as CUDAExecutionProvider; None for the processor.
    open_sizes
        Whether it shall take inputs of other sizes than the file fixes.

    Raises
    ------
    MissingDependencyError
        If ONNX Runtime is not installed.
    SourceError
        If the file cannot be read, or holds operations that cannot be run.
    ConfigError
        If there is no such provider.
    """
    file = read_onnx(path)
    runtime = optional("onnxruntime", "ONNX files need ONNX Runtime", "motes[onnx]")
    return Session(runtime, file, threads, provider, open_sizes)


_FOLDER = "session.model_external_initializers_file_folder_path"


class Session:
    """A model that is ready to run. It may be used by several threads.

    Attributes
    ----------
    file
        What its file says of it.
    """

    def __init__(
        self, runtime: Any, file: OnnxFile, threads: int | None, provider: str | None, free: bool
    ) -> None:
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
        folder = str(Path(file.path).absolute().parent)
        options.add_session_config_entry(_FOLDER, folder)
        model = file.open_sizes() if free and file.dimensions else file.path
        try:
            self._session = runtime.InferenceSession(
                model, options, providers=[provider or "CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime has errors of many kinds
            raise SourceError(
                f"{file.path} cannot be read as ONNX: {one_line(error)} Export it again, for ONNX "
                f"Runtime {runtime.__version__}."
            ) from None
        self.file = file
        self._names = [each.name for each in file.outputs]

    def run(self, inputs: Mapping[str, NDArray[Any]]) -> Arrays:
        """Return all outputs by name, in arrays of their own.

        Raises
        ------
        SourceError
            If the model does not run with these inputs.
        """
        try:
            return dict(zip(self._names, self._session.run(self._names, inputs), strict=True))
        except Exception as error:  # onnxruntime has errors of many kinds
            raise SourceError(f"{self.file.path} does not run: {one_line(error)}") from None


_PLACES = re.compile(
    r"\[ONNXRuntimeError\] : \d+ : \w+ : |Load model from .*? failed:|/\S+:\d+ .*?\) "
)
"""What ONNX Runtime says of itself: its own codes, and the places and functions of its source."""


def one_line(error: Exception) -> str:
    """Return an error of another library in one line."""
    return _PLACES.sub("", " ".join(str(error).split()))[:300].rstrip(".") + "."
